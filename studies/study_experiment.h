#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/program.h"
#include "core/archive.h"
#include "experiments/experiment.h"

namespace powdercal {

/// A response as it was observed in the laboratory.
struct ObservedResponse {
  std::string response;             ///< name without the experiment
  double value = 0;                 ///< SI
  double sd = 0;                    ///< SI, standard deviation of the observation, > 0
  std::optional<double> tolerance;  ///< SI; |simulated − observed| below this counts as reached
  std::string source;               ///< where the figure comes from, and what is assumed
};

/// A test of the powder as a study uses it.
struct StudyExperiment {
  std::unique_ptr<Experiment> experiment;
  std::vector<ObservedResponse> observed;
  std::optional<Fidelity> fidelity;  ///< its own; empty: that of the study's `backend` section
  /// Whether its observations are fitted. Otherwise it takes no part in the calibration; the best
  /// point may be evaluated on it afterwards.
  bool calibrate = true;

  const std::string& name() const { return experiment->name(); }

  /// Reads or writes the section below the experiment's name: its own options, `fidelity`,
  /// `observed` and `calibrate`. Files of data that `observed` names are read, relative paths from
  /// `base_folder`; written are the responses that were in them. Throws InputError.
  void Serialize(Archive& section, const std::filesystem::path& base_folder);
};

/// Reads or writes the study's `experiments`; `calibrated_only` leaves the others out when writing.
void SerializeExperiments(Archive& archive, std::vector<StudyExperiment>& experiments,
                          const std::filesystem::path& base_folder, bool calibrated_only);

}  // namespace powdercal
