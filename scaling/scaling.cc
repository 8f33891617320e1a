#include "scaling/scaling.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "core/quantity.h"
#include "scaling/modes.h"

namespace powdercal {
namespace {

class NoScaling final : public Scaling {
 public:
  const std::string& name() const override {
    static const std::string kName = "none";
    return kName;
  }
  std::string Describe() const override {
    return "simulates the experiment as it is: every group is kept, at the price of the powder's "
           "own stiffness and its short time step";
  }
  void Serialize(Archive&) override {}
  std::string ExplainUnsupported(const Conditions&) const override { return ""; }
  Conditions ToSimulation(const Conditions& experiment) const override { return experiment; }
};

class GivenScaling final : public Scaling {
 public:
  const std::string& name() const override {
    static const std::string kName = "given";
    return kName;
  }

  std::string Describe() const override {
    std::vector<std::string> stated;
    const auto add = [&](const char* what, const std::optional<double>& value, const char* unit) {
      if (value) stated.push_back(fmt::format("{} {}", what, HumanQuantity(*value, unit)));
    };
    add("Young's modulus", young_modulus_, "Pa");
    add("stress", stress_, "Pa");
    if (stress_ratio_) stated.push_back(fmt::format("{:.4g} times the stress", *stress_ratio_));
    add("gravity", gravity_, "m/s2");
    add("velocity", velocity_, "m/s");
    add("shear rate", shear_rate_, "1/s");
    if (stated.empty()) return "simulates what the study states: nothing yet";
    return fmt::format(
        "simulates what the study states ({}) and keeps all else as in the experiment; no group is "
        "kept by design",
        fmt::join(stated, ", "));
  }

  void Serialize(Archive& archive) override {
    archive.Quantity("young_modulus", young_modulus_, "Pa", kPositive);
    archive.Quantity("stress", stress_, "Pa", kPositive);
    archive.Quantity("stress_ratio", stress_ratio_, "1", kPositive);
    archive.Quantity("gravity", gravity_, "m/s2", kNonNegative);
    archive.Quantity("velocity", velocity_, "m/s", kPositive);
    archive.Quantity("shear_rate", shear_rate_, "1/s", kPositive);
    if (!archive.reading()) return;
    if (stress_ && stress_ratio_) {
      throw archive.ErrorAt("stress_ratio",
                            "'stress' and 'stress_ratio' exclude each other: give the simulation's "
                            "stress, or its ratio to the experiment's");
    }
  }

  std::string ExplainUnsupported(const Conditions& experiment) const override {
    // Not an error of Serialize(): there, the likely cause, a misspelt key, is still to be
    // reported.
    if (StatesNothing()) {
      return "mode 'given' states nothing that differs from the experiment; give young_modulus, "
             "stress, stress_ratio, gravity, velocity or shear_rate, or use mode 'none'";
    }
    if (young_modulus_) return ExplainModulus(*young_modulus_, experiment.young_modulus);
    return "";
  }

  std::string ExplainWithoutEffect(std::span<const Conditions> experiments) const override {
    if (!stress_ || AnyStress(experiments)) return "";
    return fmt::format("a stress of {} is given for the simulation, but no experiment applies one",
                       HumanQuantity(*stress_, "Pa"));
  }

  Conditions ToSimulation(const Conditions& experiment) const override {
    assert(ExplainUnsupported(experiment).empty());
    Conditions simulation = experiment;
    if (young_modulus_) simulation.young_modulus = young_modulus_;
    if (gravity_) simulation.gravity = gravity_;
    if (stress_ && experiment.stress) simulation.stress = stress_;
    if (stress_ratio_ && experiment.stress) {
      simulation.stress = *experiment.stress * *stress_ratio_;
    }
    if (velocity_ && experiment.velocity) simulation.velocity = velocity_;
    if (shear_rate_ && experiment.shear_rate) simulation.shear_rate = shear_rate_;
    return simulation;
  }

 private:
  bool StatesNothing() const {
    return !young_modulus_ && !stress_ && !stress_ratio_ && !gravity_ && !velocity_ && !shear_rate_;
  }

  std::optional<double> young_modulus_;  // [Pa]
  std::optional<double> stress_;         // [Pa]
  std::optional<double> stress_ratio_;   // [-]
  std::optional<double> gravity_;        // [m/s2]
  std::optional<double> velocity_;       // [m/s]
  std::optional<double> shear_rate_;     // [1/s]
};

}  // namespace

std::span<const std::string> ScalingNames() {
  static const std::array<std::string, 6> kNames = {"custom", "exact",       "given",
                                                    "none",   "rigid_limit", "sigma_over_e"};
  return kNames;
}

std::unique_ptr<Scaling> MakeScaling(const std::string& name) {
  if (name == "custom") return MakeCustomScaling();
  if (name == "exact") return MakeExactScaling();
  if (name == "given") return std::make_unique<GivenScaling>();
  if (name == "none") return std::make_unique<NoScaling>();
  if (name == "rigid_limit") return MakeRigidLimitScaling();
  if (name == "sigma_over_e") return MakeSigmaOverEScaling();
  throw UnknownName("scaling mode", name, ScalingNames());
}

void SerializeScaling(Archive& archive, std::unique_ptr<Scaling>& scaling) {
  if (!scaling) scaling = MakeScaling("none");
  archive.Section(
      "scaling",
      [&](Archive& section) {
        section.Require("mode");
        std::string mode = scaling->name();
        section.Choice("mode", mode, "scaling mode", ScalingNames());
        if (section.reading()) scaling = MakeScaling(mode);
        scaling->Serialize(section);
      },
      "mode");
}

}  // namespace powdercal
