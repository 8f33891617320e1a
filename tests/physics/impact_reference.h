#pragma once

#include <cmath>

#include "tests/physics/programs.h"

namespace powdercal::physics {

/// Two spheres (or a sphere and a plane, a body of infinite mass) that meet in the x–z plane, spins
/// about y. The law as docs/physics.md §1 states it, in scalars, with steps so small that their
/// size does not matter; shares nothing with the engine.
struct ReferenceImpact {
  struct Body {
    double radius = 0;  // infinite for a plane
    double mass = 0;
    double x = 0, z = 0, vx = 0, vz = 0, spin = 0;
  };

  Body a;
  Body b;
  double restitution = 1;
  double friction = 0;
  bool limit_force = false;
  bool incremental = false;

  bool against_plane() const { return std::isinf(b.mass); }
  double overlap() const {
    return against_plane() ? a.radius - a.z
                           : a.radius + b.radius - std::hypot(a.x - b.x, a.z - b.z);
  }

  /// Runs `duration` [s] in `steps` steps, from any state without contact.
  void Run(double duration, int steps) {
    const double h = duration / steps;
    double spring = 0;  // displacement [m] or force [N]
    for (int n = 0; n < steps; ++n) {
      Move(a, 0.5 * h);
      Move(b, 0.5 * h);
      Kick(h, spring);
      Move(a, 0.5 * h);
      Move(b, 0.5 * h);
    }
  }

 private:
  static void Move(Body& body, double h) {
    body.x += h * body.vx;
    body.z += h * body.vz;
  }

  void Kick(double h, double& spring) {
    const double delta = overlap();
    if (delta <= 0) {
      spring = 0;
      return;
    }
    // n from b to a, t perpendicular to it; a spin w about y moves a point at (rx, rz) by
    // (w rz, −w rx).
    const double distance = std::hypot(a.x - b.x, a.z - b.z);
    const double nx = against_plane() ? 0 : (a.x - b.x) / distance;
    const double nz = against_plane() ? 1 : (a.z - b.z) / distance;
    const double tx = nz, tz = -nx;
    const double arm_a = a.radius - delta / 2;
    const double arm_b = against_plane() ? 0 : b.radius - delta / 2;
    const double vx = a.vx - b.vx, vz = a.vz - b.vz;
    const double vn = vx * nx + vz * nz;
    const double vt = vx * tx + vz * tz - arm_a * a.spin - arm_b * b.spin;

    const double radius = against_plane() ? a.radius : Reduced(a.radius, b.radius);
    const double mass = against_plane() ? a.mass : Reduced(a.mass, b.mass);
    const double root = std::sqrt(radius * delta);
    const double sn = 2 * EffectiveYoung() * root;
    const double st = 8 * EffectiveShear() * root;
    const double damping = 2 * std::sqrt(5.0 / 6.0) * DampingRatio(restitution);
    double fn = 4.0 / 3.0 * EffectiveYoung() * root * delta - damping * std::sqrt(sn * mass) * vn;
    if (limit_force && fn < 0) fn = 0;

    spring += incremental ? -st * vt * h : vt * h;
    const double most = friction * std::abs(fn);
    const double elastic = incremental ? spring : -st * spring;
    double ft = elastic - damping * std::sqrt(st * mass) * vt;
    if (std::abs(elastic) > most) {
      ft = std::copysign(most, elastic);
      spring = incremental ? ft : -ft / st;
    }
    const double fx = fn * nx + ft * tx, fz = fn * nz + ft * tz;
    a.vx += h * fx / a.mass;
    a.vz += h * fz / a.mass;
    a.spin -= h * arm_a * ft / (0.4 * a.mass * a.radius * a.radius);
    if (against_plane()) return;
    b.vx -= h * fx / b.mass;
    b.vz -= h * fz / b.mass;
    b.spin -= h * arm_b * ft / (0.4 * b.mass * b.radius * b.radius);
  }
};

}  // namespace powdercal::physics
