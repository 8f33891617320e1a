#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "backends/embedded/vector_math.h"
#include "backends/program.h"
#include "backends/registry.h"
#include "backends/trace.h"

// Small programs whose outcome theory knows. Spheres of metal powder size, softened to 5 MPa.

namespace powdercal::physics {

using embedded::Cross;
using embedded::Dot;
using embedded::Length;
using embedded::operator+;
using embedded::operator-;
using embedded::operator*;

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kRadius = 15e-6;   // [m] where nothing else is said
inline constexpr double kDensity = 8220;   // [kg/m3]
inline constexpr double kYoung = 5e6;      // [Pa]
inline constexpr double kPoisson = 0.3;    // [-]
inline constexpr double kGravity = 9.81;   // [m/s2]
inline constexpr double kTimeStep = 1e-7;  // [s] about 0.03 Rayleigh times

inline double EffectiveYoung() { return kYoung / (2 * (1 - kPoisson * kPoisson)); }
inline double EffectiveShear() { return kYoung / (4 * (2 - kPoisson) * (1 + kPoisson)); }
inline double MassOf(double radius) { return kDensity * 4 / 3 * kPi * radius * radius * radius; }
inline double InertiaOf(double radius) { return 0.4 * MassOf(radius) * radius * radius; }
/// a b/(a + b): R* of two radii, m* of two masses.
inline double Reduced(double a, double b) { return a * b / (a + b); }

/// Damping ratio for a restitution, −ln e/√(ln² e + π²).
inline double DampingRatio(double restitution) {
  const double log_e = std::log(restitution);
  return -log_e / std::sqrt(log_e * log_e + kPi * kPi);
}

/// Duration of an elastic Hertzian impact (Johnson, Contact Mechanics, 1985, §11.4):
/// 2.94 δ_max/v, δ_max = (15 m* v²/(16 √R* E*))^(2/5).
inline double HertzOverlap(double radius, double mass, double speed) {
  return std::pow(15 * mass * speed * speed / (16 * std::sqrt(radius) * EffectiveYoung()), 0.4);
}
inline double HertzDuration(double radius, double mass, double speed) {
  return 2.9432 * HertzOverlap(radius, mass, speed) / speed;
}
/// Overlap under a steady force.
inline double HertzOverlapUnder(double force, double radius) {
  return std::pow(0.75 * force / (EffectiveYoung() * std::sqrt(radius)), 2.0 / 3.0);
}

inline Sphere Ball(std::int64_t id, double radius, const Vector3& position,
                   const Vector3& velocity = {}, const Vector3& spin = {}) {
  return {id, radius, position, velocity, spin};
}

/// Spheres in an open box of 20 mm about the origin; no gravity, no walls, no friction, elastic.
inline Program Vacuum(Packing packing, double time_step = kTimeStep) {
  Program program;
  program.experiment = "theory";
  program.particles.packing = std::move(packing);
  const ContactParameters contact = {.restitution = 1};
  program.materials = {.density = kDensity,
                       .young_modulus = kYoung,
                       .poisson_ratio = kPoisson,
                       .particle_particle = contact,
                       .particle_wall = contact};
  program.domain = {
      {-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01}, {Boundary::open, Boundary::open, Boundary::open}};
  program.gravity = {};
  program.time_step = time_step;
  return program;
}

inline void SetContact(Program& program, const ContactParameters& contact) {
  program.materials.particle_particle = contact;
  program.materials.particle_wall = contact;
}

inline PlaneWall Floor(double z = 0) { return {.name = "floor", .position = z}; }

/// A sphere of kRadius on a floor at z = 0, pressed on it by its weight; gravity tilted by `slope`
/// [rad] so that it pulls along +x.
inline Program OnFloor(const ContactParameters& contact, double slope = 0) {
  const double weight = MassOf(kRadius) * kGravity * std::cos(slope);
  const double overlap = HertzOverlapUnder(weight, kRadius);
  Program program = Vacuum({Ball(1, kRadius, {0, 0, kRadius - overlap})});
  SetContact(program, contact);
  program.walls = {Floor()};
  program.gravity = {kGravity * std::sin(slope), 0, -kGravity * std::cos(slope)};
  return program;
}

inline Trace RunProgram(const Program& program) {
  return MakeBackend("embedded")->Run(program, {});
}

inline Trace RunOk(const Program& program) {
  Trace trace = RunProgram(program);
  EXPECT_EQ(trace.outcome.reason, Reason::ok) << trace.outcome.message;
  return trace;
}

/// The program's particles after `duration` [s].
inline Packing After(Program program, double duration) {
  program.stages.push_back(Advance{.name = "end", .duration = duration});
  const Trace trace = RunOk(program);
  return trace.moments.empty() ? Packing{} : trace.moments.back().packing;
}

/// Moments every so many steps.
inline std::vector<Moment> Trajectory(Program program, double duration, int every,
                                      std::vector<Motion> motions = {}) {
  program.stages.push_back(Advance{
      .name = "way", .duration = duration, .motions = std::move(motions), .packing_every = every});
  return RunOk(program).moments;
}

/// States how close a test came; shown in its output and kept in its report.
inline void Measured(const std::string& what, double value) {
  std::printf("[ measured ] %s: %.3g\n", what.c_str(), value);
  ::testing::Test::RecordProperty(what, fmt::format("{:.6g}", value));
}

inline double RelativeError(double value, double expected) {
  return std::abs(value - expected) / std::abs(expected);
}

}  // namespace powdercal::physics
