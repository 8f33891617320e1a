#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "core/table.h"
#include "surrogates/surrogate.h"

namespace powdercal {

/// Answers a study from a CSV file of known evaluations, through a surrogate fitted to its rows. No
/// simulation is run; optimizers can be tried on it in seconds. In a study:
///
///   backend: {name: table, file: hastelloy_x_table3.csv, surrogate: gaussian_process}
///
/// The file (core/table.h) has one row per evaluation and a column for each free parameter of the
/// study, by its canonical name, and for each response asked for, as "experiment.response":
///
///   cohesion_energy_density [J/m3],rolling_friction,consolidation.void_ratio
///
/// Each response has its own surrogate; `surrogate: best` takes for each the one that SelectBest()
/// (surrogates/validation.h) finds on its column. Its inputs are the parameters, mapped linearly
/// (also those that the study searches on a log scale) onto [0, 1] from the smallest box that holds
/// the study's ranges and all rows. A run reports the surrogate's mean with variance 0, since a
/// table is free of noise; the surrogate's own standard deviation is the diagnostic figure
/// "RESPONSE.surrogate_sd". A program is known by its parameters and its experiment alone: size,
/// seed and law have no effect.
class TableBackend final : public Backend {
 public:
  static constexpr const char* kBest = "best";

  struct Options {
    std::string file;                            ///< CSV; relative to the study file's folder
    std::string surrogate = "gaussian_process";  ///< a name, or kBest

    void Serialize(Archive& archive);
  };

  TableBackend() = default;
  explicit TableBackend(Options options) : options_(std::move(options)) {}

  const std::string& name() const override;
  Availability availability() const override;
  bool simulates() const override { return false; }
  void Serialize(Archive& archive) override;

  /// Throws InputError if the file cannot be read, has a bad row or fewer than 3, or lacks a column
  /// for a parameter or a response. Warns where the study's ranges go beyond the data by more than
  /// a tenth of the data's own range, and of input columns that vary but are not free in the study.
  std::vector<std::string> Prepare(const BackendProblem& problem) override;

  /// SHA-256 of the file's bytes, the surrogate's name (`best`: of each response), the parameters
  /// and the box.
  std::string Fingerprint() const override { return fingerprint_; }
  /// Once prepared: "consolidation.void_ratio by gaussian_process".
  std::string Describe() const override;
  std::string ExplainUnsupported(const Program& program) const override;
  Trace Run(const Program& program, const RunContext& context) const override;

 private:
  std::vector<std::string> FindBox(const BackendProblem& problem, const Table& table);
  std::string FingerprintOf(const std::string& text) const;
  void FitResponses(const BackendProblem& problem, const Table& table);
  Eigen::VectorXd ToBox(const Program& program) const;

  Options options_;
  InputError::Details place_;  // of `file` in the study

  std::vector<BackendProblem::FreeParameter> box_;                     // with the box's bounds
  std::map<std::string, std::unique_ptr<const Surrogate>> responses_;  // by "experiment.response"
  std::string fingerprint_;
};

}  // namespace powdercal
