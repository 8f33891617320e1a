#pragma once

#include <memory>
#include <string>
#include <vector>

#include "optimizers/designs/design.h"
#include "optimizers/optimizer.h"
#include "studies/study.h"

namespace powdercal::comparison {

/// An optimizer that takes part.
struct Contestant {
  std::string label;            ///< as it was asked for: "bayesian:acquisition=ei"
  std::string name;             ///< of the optimizer
  std::string description;      ///< one line
  std::string options;          ///< resolved, as YAML, without the initial design
  bool study_options = false;   ///< its options are those of the study
  bool initial_design = false;  ///< it begins with the common initial design
  bool design = false;          ///< it is a design itself: its points are fixed beforehand
};

/// An optimizer that cannot treat the study.
struct Refusal {
  std::string label;
  std::string reason;  ///< with alternatives, where there are any
};

/// Names of optimizers from a command line, "bayesian:acquisition=ei,jitter=0.1,random": a piece
/// with '=' that names no optimizer before a colon belongs to the optimizer before it.
std::vector<std::string> SplitLabels(const std::string& text);

/// Who takes part in a comparison on a study, and with which options: the optimizer that the study
/// names with the options it has there, all others with their defaults, or as their label says.
/// Designs have as many points as the budget allows. All that begin with an initial design begin
/// with the same points: those of the study's own optimizer where it has one, else of a Sobol'
/// sequence, made anew for each seed where the design depends on one.
class Field {
 public:
  /// Without labels every optimizer takes part. Those that cannot treat the study are refused with
  /// their reason. Throws InputError for unknown names and options, a label that is given twice,
  /// and where nobody is left. The study must outlive it.
  Field(Study& study, const std::vector<std::string>& labels, int evaluations);

  const std::vector<Contestant>& contestants() const { return contestants_; }
  const std::vector<Refusal>& refused() const { return refused_; }
  const DesignOptions& initial_design() const { return initial_design_; }

  /// `seed`: 1, 2, …; with it the initial design and the optimizer's own stream change.
  std::unique_ptr<Optimizer> Make(const Contestant& contestant, int seed) const;
  /// Of the initial design and the optimizer, from the study's own seed.
  std::uint64_t SeedOf(int seed) const;

 private:
  std::unique_ptr<OptimizerFactory> MakeFactory(const Contestant& contestant,
                                                const DesignOptions& design) const;
  void Add(const std::string& label, bool asked_for);

  Study& study_;
  Objectives objectives_;
  int evaluations_;
  DesignOptions initial_design_;
  std::vector<Contestant> contestants_;
  std::vector<Refusal> refused_;
};

}  // namespace powdercal::comparison
