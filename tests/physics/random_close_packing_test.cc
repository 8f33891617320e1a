#include <gtest/gtest.h>

#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

constexpr int kCount = 1000;
constexpr int kSeeds = 3;

struct Bed {
  double void_ratio = 0;
  double largest_stress_error = 0;  // of the three edges, relative
  double late_change = 0;           // of the volume in the last tenth of the time, relative
};

// Frictionless, cohesionless spheres, compressed alike from all sides in a periodic cell.
Bed Compress(const SizeDistribution& sizes, double stress, std::uint64_t seed) {
  const double solid = kCount * kPi / 6 * sizes.Moment(3);
  const double edge = std::cbrt(solid / 0.32);
  const double smallest = sizes.Quantile(0) / 2;
  Program program = Vacuum({}, 0.2 * RayleighTime(smallest, kDensity, kYoung, kPoisson));
  program.particles = {.sizes = sizes, .count = kCount, .seed = seed};
  SetContact(program, {.restitution = 0.4});
  program.domain = {
      {0, 0, 0}, {edge, edge, edge}, {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  const double inertial_time = sizes.Moment(1) * std::sqrt(kDensity / stress);
  Deform compress{
      .name = "compress", .duration = 60 * inertial_time, .relaxation_rate = 4e-3 / inertial_time};
  for (EdgeControl& control : compress.edges) control = {EdgeControl::Kind::stress, stress};
  program.stages = {Insert{0, edge, {}}, compress};
  const Trace trace = RunOk(program);
  Bed bed;
  if (trace.moments.empty()) return bed;
  const Moment& end = trace.moments.back();
  double volume = 0;
  for (const Sphere& s : end.packing) volume += 4.0 / 3 * kPi * std::pow(s.radius, 3);
  const Vector3 lengths = end.cell->upper - end.cell->lower;
  bed.void_ratio = lengths[0] * lengths[1] * lengths[2] / volume - 1;
  const Vector3& before = trace.cell.lengths[trace.cell.lengths.size() * 9 / 10];
  bed.late_change =
      std::abs(before[0] * before[1] * before[2] / (lengths[0] * lengths[1] * lengths[2]) - 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bed.largest_stress_error =
        std::max(bed.largest_stress_error, std::abs(end.cell->stress[axis][axis] / stress - 1));
  }
  return bed;
}

double MeanVoidRatio(const SizeDistribution& sizes, double stress) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Bed bed = Compress(sizes, stress, seed);
    EXPECT_LT(bed.largest_stress_error, 0.05) << "seed " << seed;
    EXPECT_LT(bed.late_change, 2e-3) << "seed " << seed;
    sum += bed.void_ratio / kSeeds;
  }
  return sum;
}

// Random close packing of equal spheres fills 0.64 of space (Scott & Kilgour 1969, J. Phys. D
// 2:863; O'Hern et al. 2003, Phys. Rev. E 68:011306), e = 0.56; overlaps bring e down as the
// pressure rises.
TEST(RandomClosePacking, OfFrictionlessSpheres) {
  const SizeDistribution equal{.mean = 2 * kRadius};
  const double soft = MeanVoidRatio(equal, 200);
  const double stiff = MeanVoidRatio(equal, 20);
  // Overlaps go as sigma^(2/3), and so does what they take from e.
  const double ratio = std::pow(10, 2.0 / 3);
  const double limit = stiff + (stiff - soft) / (ratio - 1);
  Measured("void ratio at 200 Pa", soft);
  Measured("void ratio at 20 Pa", stiff);
  Measured("void ratio in the limit of no pressure", limit);
  EXPECT_NEAR(limit, 0.56, 0.02);
  EXPECT_LT(soft, stiff);

  const SizeDistribution spread{SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  const double mixed = MeanVoidRatio(spread, 20);
  Measured("void ratio of a spread of sizes at 20 Pa", mixed);
  EXPECT_LT(mixed, stiff);
  EXPECT_GT(mixed, stiff - 0.06);
}

}  // namespace
}  // namespace powdercal::physics
