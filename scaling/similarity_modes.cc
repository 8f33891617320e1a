#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/quantity.h"
#include "scaling/groups.h"
#include "scaling/modes.h"

namespace powdercal {

std::string ExplainModulus(double simulation, const std::optional<double>& powder) {
  if (!powder || simulation <= *powder) return "";
  return fmt::format(
      "the simulation's Young's modulus ({}) is above the powder's ({}); scaling may only soften "
      "the particles",
      HumanQuantity(simulation, "Pa"), HumanQuantity(*powder, "Pa"));
}

bool AnyStress(std::span<const Conditions> experiments) {
  return std::any_of(experiments.begin(), experiments.end(),
                     [](const Conditions& conditions) { return conditions.stress.has_value(); });
}

void SofteningScaling::Serialize(Archive& archive) {
  archive.Require("young_modulus");
  archive.Quantity("young_modulus", young_modulus_, "Pa", kPositive);
}

std::string SofteningScaling::ExplainUnsupported(const Conditions& experiment) const {
  if (!young_modulus_) {
    return fmt::format("mode '{}' needs young_modulus, that of the simulated particles", name());
  }
  if (!experiment.young_modulus) {
    return fmt::format("mode '{}' needs the powder's own Young's modulus (material.young_modulus)",
                       name());
  }
  return ExplainModulus(*young_modulus_, experiment.young_modulus);
}

std::string SofteningScaling::LoweredTo() const {
  return young_modulus_ ? fmt::format(" (lowered to {})", HumanQuantity(*young_modulus_, "Pa"))
                        : "";
}

void KeepCohesion(const Conditions& experiment, double factor, Conditions* simulation) {
  simulation->surface_energy.reset();
  simulation->cohesion_energy_density.reset();
  if (!experiment.surface_energy || !experiment.diameter) return;
  const double energy = factor * *experiment.surface_energy;
  if (simulation->law_of_cohesion == Conditions::Cohesion::dmt) {
    simulation->surface_energy = energy;
  } else if (simulation->law_of_cohesion == Conditions::Cohesion::sjkr2 &&
             simulation->young_modulus && simulation->poisson_ratio) {
    const double radius = *experiment.diameter / 4;
    simulation->cohesion_energy_density = CohesionOfPullOffSjkr2(
        PullOffForceDmt(energy, radius), radius,
        EffectiveModulus(*simulation->young_modulus, *simulation->poisson_ratio));
  }
}

namespace {

class ExactScaling final : public SofteningScaling {
 public:
  const std::string& name() const override {
    static const std::string kName = "exact";
    return kName;
  }

  std::string Describe() const override {
    return fmt::format(
        "keeps every group: stress, gravity and cohesion fall in proportion to Young's modulus{}, "
        "speeds with its root; the simulation takes as many steps as without scaling",
        LoweredTo());
  }

  bool scales_cohesion() const override { return true; }

  Conditions ToSimulation(const Conditions& experiment) const override {
    assert(ExplainUnsupported(experiment).empty());
    const double factor = *young_modulus_ / *experiment.young_modulus;
    const double root = std::sqrt(factor);
    const auto scale = [](std::optional<double>& value, double by) {
      if (value) *value *= by;
    };
    Conditions simulation = experiment;
    simulation.young_modulus = young_modulus_;
    scale(simulation.stress, factor);
    scale(simulation.gravity, factor);
    scale(simulation.velocity, root);
    scale(simulation.shear_rate, root);
    simulation.speed_ratio = experiment.speed_ratio * root;
    KeepCohesion(experiment, factor, &simulation);
    return simulation;
  }
};

class SigmaOverEScaling final : public SofteningScaling {
 public:
  const std::string& name() const override {
    static const std::string kName = "sigma_over_e";
    return kName;
  }

  std::string Describe() const override {
    return fmt::format(
        "keeps sigma/E: the stress falls in proportion to Young's modulus{}; gravity, cohesion and "
        "speeds stay as they are, and so grow against the reduced load",
        LoweredTo());
  }

  std::string ExplainWithoutEffect(std::span<const Conditions> experiments) const override {
    if (AnyStress(experiments)) return "";
    return "mode 'sigma_over_e' needs an applied stress, and no experiment has one";
  }

  Conditions ToSimulation(const Conditions& experiment) const override {
    assert(ExplainUnsupported(experiment).empty());
    Conditions simulation = experiment;
    simulation.young_modulus = young_modulus_;
    if (experiment.stress) {
      simulation.stress = *experiment.stress * (*young_modulus_ / *experiment.young_modulus);
    }
    return simulation;
  }
};

class RigidLimitScaling final : public Scaling {
 public:
  const std::string& name() const override {
    static const std::string kName = "rigid_limit";
    return kName;
  }

  std::string Describe() const override {
    return fmt::format(
        "keeps stress, gravity, speeds and the pull-off force, and lowers Young's modulus until "
        "kappa is {:.4g} under the study's largest stress: particles so stiff that how stiff they "
        "are should not matter",
        kappa_);
  }

  void Serialize(Archive& archive) override {
    archive.Quantity("kappa", kappa_, "1", {.lower = 1, .upper = 1e8});
  }

  std::string ExplainUnsupported(const Conditions& experiment) const override {
    if (!experiment.young_modulus || !experiment.poisson_ratio) {
      return "mode 'rigid_limit' needs the powder's own Young's modulus and Poisson's ratio "
             "(material.young_modulus, material.poisson_ratio)";
    }
    if (!LargestStress(experiment)) {
      return "mode 'rigid_limit' needs the group kappa, and no experiment of the study applies a "
             "stress; choose the stiffness yourself (mode 'given', young_modulus)";
    }
    return "";
  }

  bool scales_cohesion() const override { return true; }

  Conditions ToSimulation(const Conditions& experiment) const override {
    assert(ExplainUnsupported(experiment).empty());
    Conditions simulation = experiment;
    const double nu = *experiment.poisson_ratio;
    // One modulus for all experiments: a cohesion energy density means nothing without it.
    const double floor = std::pow(kappa_, 1.5) * (1 - nu * nu) * *LargestStress(experiment);
    simulation.young_modulus = std::min(floor, *experiment.young_modulus);
    KeepCohesion(experiment, 1, &simulation);
    return simulation;
  }

 private:
  static std::optional<double> LargestStress(const Conditions& experiment) {
    return experiment.study_stress ? experiment.study_stress : experiment.stress;
  }

  double kappa_ = kRigidStiffnessNumber;  // [-]
};

}  // namespace

std::unique_ptr<Scaling> MakeExactScaling() { return std::make_unique<ExactScaling>(); }
std::unique_ptr<Scaling> MakeSigmaOverEScaling() { return std::make_unique<SigmaOverEScaling>(); }

std::unique_ptr<Scaling> MakeRigidLimitScaling() { return std::make_unique<RigidLimitScaling>(); }

}  // namespace powdercal
