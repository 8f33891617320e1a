#pragma once

#include <map>
#include <set>
#include <string>

#include "backends/program.h"

namespace powdercal {

/// Bodies, servo and saved states as a program's stages go by, for backends that find out before a
/// run what they cannot do. The checks return "" where there is nothing against it.
class StageBodies {
 public:
  explicit StageBodies(const Program& program) : program_(program) {}

  bool Plane(const std::string& body) const;
  bool Group(const std::string& body) const;
  /// That there is such a body, and that no stage has removed it.
  std::string ExplainAbsent(const std::string& body) const;
  /// That the servo's wall faces down, where it is a plane.
  std::string ExplainFacing(const Servo& servo) const;

  void BeginServo() { state_.servo = true; }
  bool servo() const { return state_.servo; }  ///< at work

  std::string Pass(const Save& save);
  std::string Pass(const Restore& restore);
  /// `servo_wall`: the body that bears the program's servo, or "".
  std::string Pass(const Remove& remove, const std::string& servo_wall);

 private:
  // What Restore brings back.
  struct State {
    bool servo = false;
    std::set<std::string> removed;
  };

  const Program& program_;
  State state_;
  std::map<std::string, State> saved_;
};

/// That every glued particle is there and glued once, and that some particle is free.
std::string ExplainGluedGroups(const Program& program);

}  // namespace powdercal
