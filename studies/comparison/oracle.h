#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "core/random.h"
#include "studies/comparison/emulator.h"
#include "studies/planner.h"

namespace powdercal::comparison {

/// What answers for the simulator where nothing is simulated. All may be called from any thread.
class Oracle {
 public:
  virtual ~Oracle() = default;

  /// The run of a simulation, with the time it is said to take; in the same world the same
  /// arguments give the same run.
  virtual LedgerRun Simulate(std::size_t experiment, const Eigen::VectorXd& point, int replicate,
                             const RandomStream& world) const = 0;
  /// Responses without scatter, in the order of the targets.
  virtual Eigen::VectorXd Truth(const Eigen::VectorXd& point) const = 0;
  /// Whether runs scatter about the truth.
  virtual bool noisy() const = 0;
  /// Determines all answers.
  virtual std::string fingerprint() const = 0;
};

/// The emulator must outlive it.
std::unique_ptr<Oracle> MakeEmulatorOracle(const Emulator& emulator);

/// A backend that simulates nothing (`table`), asked through the planner, which must outlive it.
/// Each run is said to take one second.
std::unique_ptr<Oracle> MakeTableOracle(const Planner& planner);

}  // namespace powdercal::comparison
