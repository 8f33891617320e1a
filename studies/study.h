#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/program.h"
#include "core/archive.h"
#include "optimizers/optimizer.h"
#include "scaling/scaling.h"
#include "studies/approximation.h"
#include "studies/study_experiment.h"

namespace powdercal {

/// The real powder: what is known of it before anything is calibrated. SI units.
struct PowderSpecification {
  std::string name;                      ///< for reports, "Hastelloy X"
  double density = 0;                    ///< [kg/m3] of the solid
  double young_modulus = 0;              ///< [Pa] of the real powder
  double poisson_ratio = 0;              ///< [-]
  double restitution = 0;                ///< [-]
  double particle_friction = 0;          ///< [-]
  double wall_friction = 0;              ///< [-]
  double rolling_friction = 0;           ///< [-] where it is not a free parameter
  double cohesion_energy_density = 0;    ///< [J/m3] where it is not a free parameter
  std::optional<double> surface_energy;  ///< [J/m2] of the real powder, for the Pi table only
  SizeDistribution sizes;

  void Serialize(Archive& archive);
};

void SerializeContactLaw(Archive& archive, ContactLaw& law);

struct BackendSpecification {
  std::unique_ptr<Backend> backend;
  Fidelity fidelity = Fidelity::quick;
  /// Ascending, below `fidelity`: at which an optimizer that can may evaluate a point instead, to
  /// learn from it for less (studies/fidelities.h).
  std::vector<Fidelity> lower_fidelities;
  int replicates = 1;          ///< particle seeds of every evaluation
  int confirm_replicates = 3;  ///< particle seeds of the point that is reported as the best
  /// On which the best point is simulated as well, with the same particles, when the search is
  /// over; each simulates, and is another than `backend`. Those that cannot do it are recorded so.
  std::vector<std::unique_ptr<Backend>> confirm_with;
};

struct Budget {
  /// Parameter points, failed ones included; one at a lower fidelity counts as what it costs,
  /// compared with one at the study's.
  int evaluations = 40;
  int parallel = 0;                   ///< runs in flight at a time; 0: as many as fill the cores
  std::optional<double> wall_time;    ///< [s] of the whole study, over all its sessions
  std::optional<double> run_timeout;  ///< [s] of one run
  bool deterministic = false;         ///< tell results in asking order, whatever finishes first
  bool keep_files = false;            ///< keep the work folders of successful runs

  void Serialize(Archive& archive);
};

/// A study file, read and checked. docs/studies.md describes every key.
struct Study {
  std::string name;
  std::string description;
  std::uint64_t seed = 1;
  PowderSpecification powder;
  ContactLaw law;                 ///< before `approximations` replace parts of it
  Approximations approximations;  ///< section `approximate`
  SearchSpace space;
  std::unique_ptr<Scaling> scaling;
  Numerics numerics;
  std::vector<StudyExperiment> experiments;
  Objectives::Kind objective = Objectives::Kind::joint;
  std::unique_ptr<OptimizerFactory> optimizer;
  BackendSpecification backend;
  Budget budget;

  std::string file;                   ///< where it was read from
  std::filesystem::path base_folder;  ///< relative paths in the study start here
  std::vector<std::string> warnings;  ///< found while reading, for people

  /// Reads `path`, or the shipped study of that name. Throws InputError for anything that would not
  /// run, except what depends on this machine (see Preflight).
  static Study Load(const std::string& path, const Overrides& overrides = {});
  static Study Parse(const std::string& text, const std::string& file,
                     const std::filesystem::path& base_folder, const Overrides& overrides = {});

  /// The study with every default written out; Parse() reads it back to an equal study.
  std::string ToYaml();
  /// SHA-256 of all that determines the calibration: the resolved study without its budget, the
  /// experiments that are not calibrated, and `backend.confirm_with`.
  std::string Fingerprint();

  /// Indices into `experiments` of those that are calibrated, in order; never empty.
  std::vector<std::size_t> CalibratedExperiments() const;
  /// Indices of experiments by name, in the order of the study. Throws InputError for one that is
  /// not in the study, or is calibrated: it cannot tell how well the calibration transfers.
  std::vector<std::size_t> TransferExperiments(const std::vector<std::string>& names) const;
  Fidelity FidelityOf(std::size_t experiment) const;

  /// Of the calibrated experiments.
  Objectives MakeObjectives() const;
  /// "consolidation.void_ratio" → the observation behind each target, in MakeObjectives() order.
  std::vector<const ObservedResponse*> Observations() const;
  /// The contact law, before approximations, with the categories of these parameters.
  ContactLaw LawAt(const std::vector<double>& parameters) const;
  int parallel() const;  ///< budget.parallel with 0 replaced by the runs that fit on the cores
};

/// A parameter that a study may free.
struct FreeParameter {
  std::string name;
  std::string unit;
  std::string symbol;
  std::string description;
  /// Of a categorical one, all that it can be; empty: it is a number.
  std::vector<std::string> categories = {};
};
/// Sorted by name.
std::span<const FreeParameter> FreeParameters();
/// Puts a free parameter's value [SI; the index of a category] into the simulated powder.
void ApplyParameter(const Parameter& parameter, double value, SimulatedPowder& powder);

/// Where the shipped studies lie on this machine (source tree or installed), or empty.
std::filesystem::path LibraryFolder();
/// Names of the studies in it, sorted; in a folder of their own with that: `paper/spreading`.
std::vector<std::string> ShippedStudies();

}  // namespace powdercal
