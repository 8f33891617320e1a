#pragma once

#include <cmath>

#include "backends/program.h"

namespace powdercal::embedded {

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Vector3 operator-(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Vector3 operator-(const Vector3& a) { return {-a[0], -a[1], -a[2]}; }

inline Vector3 operator*(double factor, const Vector3& a) {
  return {factor * a[0], factor * a[1], factor * a[2]};
}

inline double Dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double Length(const Vector3& a) { return std::sqrt(Dot(a, a)); }

/// Requires a vector that is not zero.
inline Vector3 Unit(const Vector3& a) { return (1 / Length(a)) * a; }

/// A rotation matrix, its rows: orthogonal, determinant 1.
using Rotation = std::array<Vector3, 3>;
inline constexpr Rotation kNoRotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

inline Vector3 operator*(const Rotation& rotation, const Vector3& a) {
  return {Dot(rotation[0], a), Dot(rotation[1], a), Dot(rotation[2], a)};
}

/// The inverse rotation.
inline Rotation Transposed(const Rotation& r) {
  return {{{r[0][0], r[1][0], r[2][0]}, {r[0][1], r[1][1], r[2][1]}, {r[0][2], r[1][2], r[2][2]}}};
}

/// `second` after `first`.
inline Rotation operator*(const Rotation& second, const Rotation& first) {
  const Rotation columns = Transposed(first);
  return Transposed({second * columns[0], second * columns[1], second * columns[2]});
}

/// By |turn| [rad] about the direction of `turn`, in the right-hand sense (Rodrigues 1840); exactly
/// kNoRotation for a turn of zero.
inline Rotation RotationBy(const Vector3& turn) {
  const double angle = Length(turn);
  if (angle == 0) return kNoRotation;
  const Vector3 axis = Unit(turn);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Rotation rotation;
  for (int column = 0; column < 3; ++column) {
    const Vector3& unit = kNoRotation[column];
    rotation[column] = c * unit + s * Cross(axis, unit) + ((1 - c) * axis[column]) * axis;
  }
  return Transposed(rotation);
}

}  // namespace powdercal::embedded
