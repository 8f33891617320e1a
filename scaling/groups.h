#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scaling/conditions.h"

namespace powdercal {

// Hertz contact with cohesion (docs/physics.md). R* effective radius, E*
// effective modulus; arguments must be positive, cohesion may be zero.

/// E* = E/(2(1 − nu²)) [Pa] of two alike spheres.
double EffectiveModulus(double young_modulus, double poisson_ratio);
/// Pull-off force with SJKR2 cohesion, F_c = (16 pi³/3) k³ R*²/E*² [N].
double PullOffForceSjkr2(double cohesion_energy_density, double effective_radius,
                         double effective_modulus);
/// Its inverse: k [J/m3] of the pull-off force [N].
double CohesionOfPullOffSjkr2(double pull_off_force, double effective_radius,
                              double effective_modulus);
/// Pull-off force of a DMT contact, F_c = 4 pi gamma R* [N] (Derjaguin, Muller
/// & Toporov 1975).
double PullOffForceDmt(double surface_energy, double effective_radius);
/// Overlap at which cohesion and elasticity balance, delta_0 = 9 pi² (k/E*)² R*
/// [m].
double EquilibriumOverlapSjkr2(double cohesion_energy_density, double effective_radius,
                               double effective_modulus);
/// Stiffness number, kappa = (E/((1 − nu²) sigma))^(2/3) [-]; overlap/diameter
/// goes as 1/kappa.
double StiffnessNumber(double young_modulus, double poisson_ratio, double stress);

/// A named Pi group evaluated for the laboratory and for the simulation.
struct GroupComparison {
  /// By the factor f = max(ratio, 1/ratio): `ok` up to the group's tolerance,
  /// `warn` up to kViolationFactor, `violated` beyond; `unknown` where a side
  /// is. A zero on one side only is `violated`. Always `ok`, with a remark that
  /// says why:
  /// - sigma/E, kappa, rho g d/E, delta_0/d, which act through overlaps alone,
  /// while the overlap
  ///   that each implies is at most d/kRigidStiffnessNumber on both sides (for
  ///   sigma/E and kappa: kappa is at least kRigidStiffnessNumber): the
  ///   particles are as good as rigid;
  /// - I, while at most kQuasiStaticInertialNumber on both sides: rates should
  /// not matter;
  /// - sigma/(rho_b g h) and Bo, while the load is at least kLoadOverWeight
  /// times the bed's weight
  ///   on both sides: gravity should not matter;
  /// - groups that do not matter for the test at hand (scaling/relevance.h).
  /// Numerical groups have no laboratory's value: they are judged by limits of
  /// their own.
  enum class Verdict { ok, warn, violated, unknown };
  std::string symbol;                ///< "sigma/E"
  std::string meaning;               ///< one line
  std::optional<double> experiment;  ///< [-]
  std::optional<double> simulation;  ///< [-]
  std::optional<double> ratio;  ///< simulation/experiment; empty where a side is unknown, or the
                                ///< experiment's value alone is zero
  Verdict verdict = Verdict::unknown;
  std::string remark;    ///< a plain sentence where the group is not matched; else ""
  double tolerance = 0;  ///< factor up to which it is `ok`; numerical groups: the value
  std::string source;    ///< where the tolerance comes from
  bool numerical = false;
};
const std::string& ToString(GroupComparison::Verdict verdict);

inline constexpr double kMatchFactor = 1.1;  ///< tolerance where there is no better one
inline constexpr double kViolationFactor = 10;
inline constexpr double kRigidStiffnessNumber = 1e3;
inline constexpr double kQuasiStaticInertialNumber = 1e-3;
inline constexpr double kLoadOverWeight = 10;

/// All named groups of docs/physics.md that have a value on at least one side,
/// in this order: sigma/E, kappa, k/E, rho g d/E, sigma/(rho_b g h), F_c/(sigma
/// d^2), Bo, W/(m g d), I, V/sqrt(g d), gap/d, L/d, delta_0/d, F_w/F_c, nu, mu,
/// mu_w, mu_r, e_n; then the numerical ones, dt/T_R, chi, servo gain. Equal
/// spheres of the mean diameter d: R* = d/4, m = pi/6 rho d³; rho_b = rho ·
/// solid fraction. F_c, W and delta_0 follow from each side's own cohesion:
/// SJKR2 where k is known, else DMT; F_w, the pull-off force at a wall, too.
/// `test`: the experiment's name, for what matters in it.
std::vector<GroupComparison> CompareGroups(const Conditions& experiment,
                                           const Conditions& simulation,
                                           const std::string& test = "");

/// (symbol, value) of the groups that have a value, same order and symbols.
std::vector<std::pair<std::string, double>> EvaluateGroups(const Conditions& conditions);
/// The value of one group; empty where it has none.
std::optional<double> EvaluateGroup(const std::string& symbol, const Conditions& conditions);
/// Symbols of the groups that a change of conditions can match, in the order
/// above.
std::vector<std::string> MatchableGroups();

}  // namespace powdercal
