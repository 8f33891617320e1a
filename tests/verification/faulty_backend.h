#pragma once

#include <functional>
#include <string>
#include <utility>

#include "backends/registry.h"

namespace powdercal::verification {

/// The embedded engine with a fault: it simulates another program than the one that it is given.
class FaultyBackend final : public Backend {
 public:
  using Fault = std::function<void(Program&)>;

  FaultyBackend(std::string name, Fault fault)
      : name_(std::move(name)), fault_(std::move(fault)), engine_(MakeBackend("embedded")) {}

  const std::string& name() const override { return name_; }
  Availability availability() const override { return engine_->availability(); }
  std::string ExplainUnsupported(const Program& program) const override {
    return engine_->ExplainUnsupported(program);
  }
  Trace Run(const Program& program, const RunContext& context) const override {
    Program changed = program;
    fault_(changed);
    return engine_->Run(changed, context);
  }

 private:
  std::string name_;
  Fault fault_;
  std::unique_ptr<Backend> engine_;
};

inline FaultyBackend::Fault NoFault() {
  return [](Program&) {};
}
inline FaultyBackend::Fault MoreFriction() {
  return [](Program& program) {
    program.materials.particle_particle.friction *= 1.05;
    program.materials.particle_wall.friction *= 1.05;
  };
}
/// Twice the stiffness at walls: where there is one sphere, all its contacts are with walls.
inline FaultyBackend::Fault StiffWalls() {
  return [](Program& program) {
    if (program.particles.packing->size() > 1) return;
    program.materials.young_modulus *= 2;
    program.materials.linear.normal *= 2;
    program.materials.linear.tangential *= 2;
  };
}
inline FaultyBackend::Fault NoRolling() {
  return [](Program& program) { program.law.rolling = ContactLaw::Rolling::none; };
}

}  // namespace powdercal::verification
