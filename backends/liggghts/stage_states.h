#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "backends/program.h"

namespace powdercal::liggghts {

/// The program's first servo, or null; all its servos are on one wall.
const Servo* FirstServo(const Program& program);

/// The last stage that leaves a moment in the trace: where the run ends.
std::optional<std::size_t> LastMoment(const Program& program);
bool LeavesMoment(const Stage& stage);

/// Whether particles may leave.
bool HasOutflow(const Program& program);

/// A body in one stage, as far as the program alone tells.
struct BodyState {
  double height = 0;       ///< [m] as WallState, at the beginning of the stage
  Vector3 displacement{};  ///< [m] at the beginning of the stage
  Vector3 velocity{};      ///< [m/s] throughout the stage
};

/// What is there in one stage.
struct StageState {
  double begin = 0;                         ///< [steps]
  const Servo* servo = nullptr;             ///< in force, this stage's own if it is a servo
  std::map<std::string, BodyState> bodies;  ///< by name; not the servo's
};

/// The states of all stages, by number. `ends` are the steps at which they end; Save, Restore and
/// Remove take none. Steps count on after a Restore.
std::vector<StageState> StatesOf(const Program& program, const std::vector<double>& ends);

}  // namespace powdercal::liggghts
