#include "experiments/packing_measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "backends/insertion.h"
#include "core/random.h"

namespace powdercal {
namespace {

constexpr double kPi = std::numbers::pi;

Domain Box(double width, double height) {
  Domain domain;
  domain.upper = {width, width, height};
  return domain;
}

// n³ touching unit-diameter spheres, scaled so that neighbours overlap by `overlap`.
Packing SimpleCubic(int n, double overlap = 0) {
  Packing packing;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) {
        const double a = 1 - overlap;
        packing.push_back({static_cast<std::int64_t>(packing.size()) + 1,
                           0.5,
                           {(x + 0.5) * a, (y + 0.5) * a, (z + 0.5) * a}});
      }
    }
  }
  return packing;
}

Packing FaceCentredCubic(int n) {
  const double a = std::numbers::sqrt2;  // unit diameters touch along the face diagonal
  Packing packing;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) {
        for (const Vector3& p :
             {Vector3{0, 0, 0}, Vector3{0, .5, .5}, Vector3{.5, 0, .5}, Vector3{.5, .5, 0}}) {
          packing.push_back({static_cast<std::int64_t>(packing.size()) + 1,
                             0.5,
                             {(x + p[0]) * a, (y + p[1]) * a, (z + p[2]) * a}});
        }
      }
    }
  }
  return packing;
}

TEST(SphereSlabVolume, HasItsClosedForms) {
  const Sphere sphere{1, 2, {0, 0, 5}};
  const double full = 4.0 / 3 * kPi * 8;
  EXPECT_DOUBLE_EQ(SphereSlabVolume(sphere, -10, 10), full);
  EXPECT_DOUBLE_EQ(SphereSlabVolume(sphere, 5, 10), full / 2);
  EXPECT_EQ(SphereSlabVolume(sphere, 8, 10), 0);
  EXPECT_DOUBLE_EQ(SphereSlabVolume(sphere, 6, 10), kPi / 3 * 1 * (3 * 2 - 1));  // cap of height 1
  double sum = 0;
  for (int i = 0; i < 7; ++i)
    sum += SphereSlabVolume(sphere, 3 + i * 4.0 / 7, 3 + (i + 1) * 4.0 / 7);
  EXPECT_NEAR(sum, full, 1e-13);
}

TEST(SphereSlabVolume, AgreesWithMonteCarlo) {
  const Sphere sphere{1, 1, {0, 0, 0}};
  RandomStream random(3);
  constexpr int kSamples = 400000;
  int inside = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = random.Uniform(-1, 1);
    const double y = random.Uniform(-1, 1);
    const double z = random.Uniform(-0.3, 0.7);
    if (x * x + y * y + z * z < 1) ++inside;
  }
  EXPECT_NEAR(SphereSlabVolume(sphere, -0.3, 0.7), 4.0 * inside / kSamples, 0.013);
}

TEST(LensVolume, HasItsClosedForms) {
  // Equal spheres: two caps of height delta/2.
  const double h = 0.05;
  EXPECT_NEAR(LensVolume(1, 1, 2 - 2 * h), 2 * kPi * h * h / 3 * (3 - h), 1e-15);
  // Unequal ones: a cap of each, cut by the plane of the lens.
  const double arm = (1.2 * 1.2 + 1 - 0.25) / 2.4;
  const double caps = SphereVolumeBelow(1, -arm) + SphereVolumeBelow(0.5, -(1.2 - arm));
  EXPECT_NEAR(LensVolume(1, 0.5, 1.2), caps, 1e-14);
  EXPECT_EQ(LensVolume(1, 0.5, 1.5), 0);
  EXPECT_DOUBLE_EQ(LensVolume(1, 0.5, 0.2), 4.0 / 3 * kPi * 0.125);
  EXPECT_DOUBLE_EQ(LensVolume(0.5, 1, 1.2), LensVolume(1, 0.5, 1.2));
}

// A wall against a very large sphere is the limit of a lens.
TEST(LensVolume, BecomesACapAtAWall) {
  const double cap = SphereVolumeBelow(1, -0.9);
  EXPECT_NEAR(LensVolume(1, 1e5, 1e5 + 0.9) / cap, 1, 1e-4);
}

TEST(VoidRatio, OfLattices) {
  const Packing cubic = SimpleCubic(10);
  const Domain domain = Box(10, 10);
  const double expected = 6 / kPi - 1;
  const VoidRatio central = CentralVoidRatio(cubic, {}, domain, 0, 10);
  EXPECT_EQ(central.bottom, 2);
  EXPECT_EQ(central.top, 8);
  EXPECT_NEAR(central.value, expected, 1e-12);
  EXPECT_NEAR(WallToWallVoidRatio(cubic, {}, domain, 0, 10).value, expected, 1e-12);
  // Between heights that cut spheres, but hold whole periods.
  EXPECT_NEAR(MeasureVoidRatio(cubic, {}, domain, 2.3, 6.3).value, expected, 1e-12);

  const double a = std::numbers::sqrt2;
  EXPECT_NEAR(MeasureVoidRatio(FaceCentredCubic(5), {}, Box(5 * a, 5 * a), a, 3 * a).value,
              3 * std::numbers::sqrt2 / kPi - 1, 1e-12);
  EXPECT_TRUE(std::isinf(MeasureVoidRatio({}, {}, domain, 0, 1).value));
}

// Each sphere has six neighbours or walls, so three lenses of two caps: the space that the spheres
// really occupy is one sphere less six caps per cell.
TEST(VoidRatio, CountsOverlapsOnce) {
  const double overlap = 0.04;
  const double a = 1 - overlap;
  const Packing packing = SimpleCubic(5, overlap);
  const Domain domain = Box(5 * a, 5 * a);
  const std::vector<WallPlane> walls = {{0, true}, {5 * a, false}};
  const Contacts contacts = FindContacts(packing, domain, walls);
  const double cap = SphereVolumeBelow(0.5, -a / 2);
  const double whole = kPi / 6;
  const VoidRatio wall = WallToWallVoidRatio(packing, contacts, domain, 0, 5 * a);
  EXPECT_NEAR(wall.value, a * a * a / whole - 1, 1e-12);
  EXPECT_NEAR(wall.overlap_corrected, a * a * a / (whole - 6 * cap) - 1, 1e-12);
  EXPECT_NEAR(wall.overlap_volume, 125 * 6 * cap, 1e-12);
  // A period that starts between the planes of the lenses.
  const VoidRatio slab = MeasureVoidRatio(packing, contacts, domain, 1.5 * a, 3.5 * a);
  EXPECT_NEAR(slab.value, wall.value, 1e-12);
  EXPECT_NEAR(slab.overlap_corrected, wall.overlap_corrected, 1e-12);
  // The second-order estimate of the header.
  EXPECT_NEAR(wall.overlap_corrected - wall.value, 3 * (1 + wall.value) * 6 * overlap * overlap / 4,
              0.2 * overlap * overlap * 9);
}

// Rigid spheres on the same lattice have e = 6/pi − 1.
TEST(StiffnessShift, IsTheFirstOrderOfTheArtefact) {
  const double overlap = 0.004;
  const double a = 1 - overlap;
  const Packing packing = SimpleCubic(4, overlap);
  const Domain domain = Box(4 * a, 4 * a);
  const std::vector<WallPlane> walls = {{0, true}, {4 * a, false}};
  const Contacts contacts = FindContacts(packing, domain, walls);
  const double e = WallToWallVoidRatio(packing, contacts, domain, 0, 4 * a).value;
  const ContactStatistics statistics = MeasureContacts(packing, contacts);
  EXPECT_NEAR(statistics.mean_relative_overlap, overlap, 1e-12);
  EXPECT_NEAR(e + StiffnessShift(e, statistics.mean_relative_overlap), 6 / kPi - 1,
              20 * overlap * overlap);
}

TEST(Contacts, OfASimpleCubicLattice) {
  const Packing packing = SimpleCubic(5, 1e-6);
  const double side = 5 * (1 - 1e-6);
  const std::vector<WallPlane> walls = {{0, true}, {side, false}};
  const Contacts contacts = FindContacts(packing, Box(side, side), walls);
  EXPECT_EQ(contacts.pairs.size(), 25u * (5 + 5 + 4));
  EXPECT_EQ(contacts.walls.size(), 50u);
  const ContactStatistics statistics = MeasureContacts(packing, contacts);
  EXPECT_EQ(statistics.coordination_number, 6);
  EXPECT_EQ(statistics.mechanical_coordination_number, 6);
  EXPECT_EQ(statistics.rattler_fraction, 0);
  EXPECT_NEAR(statistics.max_overlap, 1e-6 / 0.25, 1e-12);  // R* = r/2
  Domain open = Box(side, side);
  open.boundaries = {Boundary::open, Boundary::open, Boundary::open};
  EXPECT_EQ(FindContacts(packing, open, {}).pairs.size(), 25u * (4 + 4 + 4));
}

// In a box two spheres wide each pair touches twice, through different images.
TEST(Contacts, ThroughTwoImages) {
  const Packing packing = SimpleCubic(2, 1e-6);
  const double side = 2 * (1 - 1e-6);
  EXPECT_EQ(FindContacts(packing, Box(side, side), {}).pairs.size(), 4u * (2 + 2 + 1));
}

TEST(Contacts, AgreeWithASearchOverAllPairs) {
  RandomStream random(8);
  Packing packing;
  for (int i = 0; i < 300; ++i) {
    // Some outside of the box, as a simulator may leave them.
    packing.push_back({i + 1,
                       random.Uniform(0.1, 0.5),
                       {random.Uniform(-1, 6), random.Uniform(0, 5), random.Uniform(0, 5)}});
  }
  const Domain domain = Box(5, 5);
  const Contacts contacts = FindContacts(packing, domain, {});
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < packing.size(); ++i) {
    for (std::uint32_t j = i + 1; j < packing.size(); ++j) {
      Vector3 d;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        d[axis] = packing[j].position[axis] - packing[i].position[axis];
        if (axis < 2) d[axis] -= 5 * std::round(d[axis] / 5);
      }
      const double distance = std::hypot(d[0], d[1], d[2]);
      if (distance > packing[i].radius + packing[j].radius) continue;
      ASSERT_LT(next, contacts.pairs.size());
      const PairContact& contact = contacts.pairs[next++];
      EXPECT_EQ(contact.i, i);
      EXPECT_EQ(contact.j, j);
      EXPECT_NEAR(contact.distance, distance, 1e-12);
      EXPECT_NEAR(contact.overlap, packing[i].radius + packing[j].radius - distance, 1e-12);
    }
  }
  EXPECT_EQ(next, contacts.pairs.size());
  EXPECT_GT(next, 100u);
}

TEST(Contacts, RattlersHaveFewerThanTwo) {
  // A chain of three that overlap by 0.1, and one sphere alone.
  const Packing packing = {
      {1, 0.5, {5, 5, 1}}, {2, 0.5, {5, 5, 1.9}}, {3, 0.5, {5, 5, 2.8}}, {4, 0.5, {1, 1, 5}}};
  const Contacts contacts = FindContacts(packing, Box(10, 10), {});
  const ContactStatistics statistics = MeasureContacts(packing, contacts);
  EXPECT_DOUBLE_EQ(statistics.coordination_number, 1);
  EXPECT_DOUBLE_EQ(statistics.mechanical_coordination_number, 2);
  EXPECT_DOUBLE_EQ(statistics.rattler_fraction, 0.75);
  EXPECT_NEAR(statistics.mean_relative_overlap, 0.1, 1e-12);
  EXPECT_NEAR(contacts.pairs[0].contact_height, 1.45, 1e-12);
}

// The work of the Hertz force 4/3 E* sqrt(R*) delta^1.5, integrated numerically.
TEST(Energies, HertzEnergyIsTheWorkOfTheForce) {
  const Packing packing = {{1, 1.0, {5, 5, 0.9}}, {2, 0.5, {5, 5, 2.3}}};
  const std::vector<WallPlane> walls = {{0, true}};
  const Contacts contacts = FindContacts(packing, Box(10, 10), walls);
  ASSERT_EQ(contacts.pairs.size(), 1u);
  ASSERT_EQ(contacts.walls.size(), 1u);
  const double effective_modulus = 5e6 / (2 * (1 - 0.09));
  const auto work = [&](double radius, double overlap) {
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += std::pow((i + 0.5) / kSteps * overlap, 1.5);
    return 4.0 / 3 * effective_modulus * std::sqrt(radius) * sum * overlap / kSteps;
  };
  const double expected = work(1.0 / 3, 0.1) + work(1, 0.1);
  EXPECT_NEAR(HertzEnergy(packing, contacts, 5e6, 0.3) / expected, 1, 1e-7);
}

TEST(Energies, KineticEnergyHasBothParts) {
  const Packing packing = {{1, 0.5, {}, {3, 0, 4}, {0, 2, 0}}};
  const double mass = 1000 * kPi / 6;
  EXPECT_NEAR(KineticEnergy(packing, 1000), 0.5 * mass * 25 + 0.5 * (0.4 * mass * 0.25) * 4, 1e-9);
}

}  // namespace
}  // namespace powdercal
