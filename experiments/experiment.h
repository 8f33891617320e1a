#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "backends/program.h"
#include "backends/trace.h"
#include "core/archive.h"
#include "scaling/conditions.h"

namespace powdercal {

/// A response that an experiment can measure.
struct ResponseDescription {
  std::string name;         ///< "void_ratio"
  std::string unit;         ///< SI unit, "1" for pure numbers
  std::string description;  ///< one line, for `powdercal list` and the report
};

/// A response as a file of laboratory data gives it.
struct ObservedValue {
  std::string response;  ///< name, without the experiment's
  double value = 0;      ///< SI
  double sd = 0;         ///< SI, > 0
};

/// A measured response.
struct ResponseValue {
  double value = 0;  ///< SI
  double variance =
      0;  ///< SI², the variance of the measurement within this one simulation; 0: unknown
};

/// What one simulation of an experiment gave.
struct Measurement {
  std::map<std::string, ResponseValue> responses;
  std::map<std::string, double>
      diagnostics;  ///< SI; keys end in nothing, units in the header of each
                    ///< experiment ("coordination_number", "kappa", …)
};

/// What the simulation assumes of the powder, after scaling, with the free parameters put in.
struct SimulatedPowder {
  SizeDistribution sizes;
  Materials materials;
  ContactLaw law;
};

/// How the equations are to be integrated.
struct Numerics {
  double rayleigh_fraction =
      0.2;  ///< [-] time step over the Rayleigh time of the smallest particle
  std::optional<double> time_step;  ///< [s] overrides the rule; for demonstrations of instability

  void Serialize(Archive& archive);
  /// The time step for a powder [s].
  double TimeStep(const SimulatedPowder& powder) const;
};

/// A test of the powder, as a protocol: conditions → Program, Trace → responses.
class Experiment {
 public:
  virtual ~Experiment() = default;

  virtual const std::string& name() const = 0;
  /// Sorted by name. May depend on the options (a shear test has a response per normal stress).
  virtual std::span<const ResponseDescription> responses() const = 0;

  /// Keys under `observed` that name a file of laboratory data instead of a response, sorted:
  /// `yield_locus: shear.csv`.
  virtual std::span<const std::string> observed_files() const { return {}; }
  /// Reads such a file, after the options. May take options that the study left out from it, such
  /// as the normal stresses. Throws InputError for what is wrong with the file.
  virtual std::vector<ObservedValue> ReadObserved(const std::string& /*key*/,
                                                  const std::string& /*path*/) {
    return {};
  }

  /// Reads or writes the experiment's own options (without `observed`, which the study holds).
  virtual void Serialize(Archive& archive) = 0;

  /// Adds what this experiment knows of its own conditions in the laboratory: stress, height,
  /// velocity, … (the powder's are filled in by the study).
  virtual void DescribeConditions(Fidelity fidelity, Conditions& conditions) const = 0;

  /// Why this powder, as it is simulated, cannot be tested so, or "".
  virtual std::string ExplainUnsupported(const SimulatedPowder& /*powder*/) const { return ""; }

  /// The program for one particle seed. `conditions` are the simulation's, after scaling.
  virtual Program Plan(const SimulatedPowder& powder, const Conditions& conditions,
                       const Numerics& numerics, Fidelity fidelity, std::uint64_t seed) const = 0;

  /// Simulated time that a program of this experiment usually takes [s], for estimates of cost;
  /// right within a factor of about 2.
  virtual double ExpectedDuration(const Program& program) const = 0;

  /// Measures a trace whose outcome is ok. May still find that it is not a valid test, and then
  /// returns the reason in `outcome`.
  virtual Measurement Measure(const Program& program, const Trace& trace,
                              Outcome* outcome) const = 0;
};

/// Names of all experiments, sorted.
std::span<const std::string> ExperimentNames();
/// Throws InputError for a name that is not in ExperimentNames().
std::unique_ptr<Experiment> MakeExperiment(const std::string& name);

}  // namespace powdercal
