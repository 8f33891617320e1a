#pragma once

#include <span>
#include <string>
#include <vector>

#include "backends/program.h"
#include "backends/trace.h"

namespace powdercal {

/// Normal stress along z and shear stress in x–z [Pa], compression and resistance to shear
/// positive.
struct StressPair {
  double normal = 0;
  double shear = 0;
};

/// One window of averaging of a shear test.
struct ShearSample {
  double strain = 0;         ///< [-] since the beginning of the preshear, or of the yield
  StressPair stress;         ///< of the periodic cell, or at the top platen
  StressPair bulk;           ///< stress tensor of the powder, between platens that of the slab
  StressPair bottom;         ///< at the bottom platen; without platens like `stress`
  double complementary = 0;  ///< [Pa] the stress tensor's other shear stress, zx
  double void_ratio = 0;     ///< [-] of the cell, between platens of the slab
};
using ShearSeries = std::vector<ShearSample>;

/// What a program of PlanShear() recorded.
struct ShearRecord {
  ShearSeries preshear;             ///< all pieces in one
  std::vector<std::size_t> states;  ///< number of samples of the preshear up to each saved state
  /// By state and normal stress; strain counts from the stage's beginning.
  std::vector<std::vector<ShearSeries>> yields;
};

/// Reads a trace whose outcome is ok. Between platens the strain is the bottom's path over the
/// distance from the middle of its bumps to that of the ridges. Returns "" or what is missing.
std::string ReadShearRecord(const Program& program, const Trace& trace, ShearRecord* record);

/// Means of the samples' members; the strain is the last one's. Requires a sample.
ShearSample MeanSample(std::span<const ShearSample> samples);

struct YieldPoint {
  bool reached = false;  ///< the normal stress was, in at least one window
  StressPair stress;     ///< [Pa] both over the same window
  double strain = 0;     ///< [-] at the end of it
};

/// Strain over which yield points are averaged.
inline constexpr double kYieldWindow = 0.02;
/// Relative error of the normal stress up to which a window counts. A cell whose powder dilates
/// bears more than its target: by a third of the dilation per shear strain (see Deform), up to
/// 15 % with strong cohesion.
inline constexpr double kNormalStressTolerance = 0.20;

/// The yield point under a reduced normal stress: where the strength is largest, averaged over a
/// strain of kYieldWindow, among the windows whose own mean normal stress is within
/// kNormalStressTolerance of the target. The strength is tau − friction · (sigma − target), so that
/// a window is not preferred for bearing more load; `friction` is the steady state's tau/sigma.
/// Windows in which the load is still being reduced are left out. Presheared powder yields at once
/// when its load is taken off, and the pair of stresses then moves along the yield locus: a normal
/// stress somewhat off does no harm, as both means belong to the same window. The window is wide
/// enough that its maximum is not that of the noise: with 1000 particles the bias is 1 to 2 % of
/// the shear stress, alike at every normal stress, so that it does not look like cohesion.
YieldPoint FindYieldPoint(std::span<const ShearSample> samples, double normal, double friction);

}  // namespace powdercal
