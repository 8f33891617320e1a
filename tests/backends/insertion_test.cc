#include "backends/insertion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/errors.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

constexpr SizeDistribution kNormal{SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
constexpr SizeDistribution kEqual{SizeDistribution::Kind::monodisperse, 29e-6};

struct Case {
  Particles particles;
  Domain domain;
  Insert insert;
};

// A periodic column ten mean diameters wide whose slab is filled to the solid fraction.
Case MakeCase(const SizeDistribution& sizes, int count, double fraction, std::uint64_t seed) {
  Case c;
  c.particles.sizes = sizes;
  c.particles.count = count;
  c.particles.seed = seed;
  const double width = 10 * sizes.mean;
  c.domain.lower = {-0.5 * width, 0, 0};
  c.domain.upper = {0.5 * width, width, 1};
  c.insert.bottom = 1e-5;
  c.insert.top =
      c.insert.bottom + count * std::numbers::pi / 6 * sizes.Moment(3) / (width * width * fraction);
  c.insert.velocity = {0, 0, -0.25};
  return c;
}

Packing Place(const Case& c) { return PlaceParticles(c.particles, c.domain, c.insert); }

std::string ErrorOf(const Case& c) {
  try {
    Place(c);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// Smallest gap between any two spheres, by the nearest periodic image, over the mean radius.
double SmallestGap(const Packing& packing, const Domain& domain) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < packing.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      double squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double d = packing[i].position[axis] - packing[j].position[axis];
        const double length = domain.upper[axis] - domain.lower[axis];
        if (domain.boundaries[axis] == Boundary::periodic) d -= length * std::round(d / length);
        squared += d * d;
      }
      smallest = std::min(smallest, std::sqrt(squared) - packing[i].radius - packing[j].radius);
    }
  }
  return smallest / packing.front().radius;
}

TEST(DrawDiameters, AreStratified) {
  constexpr int kCount = 500;
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::vector<double> diameters = DrawDiameters(kNormal, kCount, seed);
    EXPECT_FALSE(std::is_sorted(diameters.begin(), diameters.end()));
    std::sort(diameters.begin(), diameters.end());
    double cubes = 0;
    for (int i = 0; i < kCount; ++i) {
      const double d = diameters[static_cast<std::size_t>(i)];
      EXPECT_GE(d, kNormal.Quantile(static_cast<double>(i) / kCount));
      EXPECT_LE(d, kNormal.Quantile((i + 1.0) / kCount));
      cubes += d * d * d;
    }
    EXPECT_NEAR(cubes / kCount / kNormal.Moment(3), 1, 2e-3);
  }
}

TEST(DrawDiameters, RefusesBadInput) {
  EXPECT_THROW(DrawDiameters(kNormal, 0, 1), InputError);
  EXPECT_THROW(DrawDiameters({SizeDistribution::Kind::normal, 29e-6}, 5, 1), InputError);
}

class Placement : public ::testing::TestWithParam<SizeDistribution> {};

TEST_P(Placement, IsWithoutOverlapAndInsideTheSlab) {
  for (const std::uint64_t seed : {1, 2}) {
    const Case c = MakeCase(GetParam(), 1000, 0.34, seed);
    const Packing packing = Place(c);
    ASSERT_EQ(packing.size(), 1000u);
    EXPECT_GE(SmallestGap(packing, c.domain), 0);
    for (std::size_t i = 0; i < packing.size(); ++i) {
      const Sphere& s = packing[i];
      EXPECT_EQ(s.id, static_cast<std::int64_t>(i) + 1);
      EXPECT_EQ(s.velocity, c.insert.velocity);
      EXPECT_GE(s.position[2] - s.radius, c.insert.bottom * (1 - 1e-12));
      EXPECT_LE(s.position[2] + s.radius, c.insert.top * (1 + 1e-12));
      for (std::size_t axis = 0; axis < 2; ++axis) {
        EXPECT_GE(s.position[axis], c.domain.lower[axis]);
        EXPECT_LT(s.position[axis], c.domain.upper[axis]);
      }
    }
    // Some sphere crosses each periodic side, or the sides would act as walls.
    for (std::size_t axis = 0; axis < 2; ++axis) {
      EXPECT_TRUE(std::any_of(packing.begin(), packing.end(), [&](const Sphere& s) {
        return s.position[axis] + s.radius > c.domain.upper[axis];
      }));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Placement, ::testing::Values(kNormal, kEqual));

TEST(PlaceParticles, StaysInsideOpenSides) {
  Case c = MakeCase(kNormal, 500, 0.25, 5);
  c.domain.boundaries = {Boundary::open, Boundary::periodic, Boundary::open};
  for (const Sphere& s : Place(c)) {
    EXPECT_GE(s.position[0] - s.radius, c.domain.lower[0] * (1 + 1e-12));
    EXPECT_LE(s.position[0] + s.radius, c.domain.upper[0] * (1 + 1e-12));
  }
}

TEST(PlaceParticles, TheIdSaysNothingOfTheSize) {
  const Packing packing = Place(MakeCase(kNormal, 1000, 0.3, 1));
  double covariance = 0;
  double variance = 0;
  for (const Sphere& s : packing) {
    const double rank = static_cast<double>(s.id) / 1000 - 0.5;
    const double size = 2 * s.radius / kNormal.Moment(1) - 1;
    covariance += rank * size;
    variance += size * size;
  }
  EXPECT_LT(std::abs(covariance) / std::sqrt(variance * 1000 / 12.0), 0.12);
}

// Bit for bit: another platform, compiler or optimisation level must give the same numbers.
TEST(PlaceParticles, IsTheSameEverywhere) {
  const Packing packing = Place(MakeCase(kNormal, 100, 0.3, 42));
  EXPECT_EQ(packing.front().radius, 0x1.caf01736426e1p-17);
  EXPECT_EQ(packing.front().position,
            (Vector3{0x1.30d98797d917cp-15, 0x1.02eef5ef2a50ep-12, 0x1.870c24c67a07ap-15}));
  EXPECT_EQ(packing.back().radius, 0x1.5ad9cee64d489p-17);
  EXPECT_EQ(packing.back().position,
            (Vector3{0x1.3616e676837e8p-16, 0x1.e50dc8a9ccc03p-15, 0x1.81e5254b0794ap-16}));
}

TEST(PlaceParticles, SeedsDiffer) {
  EXPECT_NE(Place(MakeCase(kNormal, 100, 0.2, 1)).front().position,
            Place(MakeCase(kNormal, 100, 0.2, 2)).front().position);
}

TEST(PlaceParticles, NamesTheSolidFractionWhereItFails) {
  EXPECT_THAT(ErrorOf(MakeCase(kEqual, 300, 0.45, 1)),
              AllOf(HasSubstr("300 particles"), HasSubstr("solid fraction of 0.450")));
  EXPECT_THAT(ErrorOf(MakeCase(kNormal, 300, 0.64, 1)), HasSubstr("solid fraction of 0.64"));
}

TEST(PlaceParticles, RefusesASlabThatCannotHoldASphere) {
  Case c = MakeCase(kEqual, 3, 0.1, 1);
  c.insert.top = c.insert.bottom + 20e-6;
  EXPECT_THAT(ErrorOf(c), AllOf(HasSubstr("height of the insertion slab"), HasSubstr("29 um")));
  c = MakeCase(kEqual, 3, 0.1, 1);
  c.domain.upper[1] = 20e-6;
  EXPECT_THAT(ErrorOf(c), HasSubstr("width in y"));
  c = MakeCase(kEqual, 100, 0.1, 1);
  c.domain.upper[2] = c.insert.top / 2;
  EXPECT_THAT(ErrorOf(c), HasSubstr("beyond the domain"));
}

TEST(PlaceParticles, GivesAnExplicitPackingBackAsItIs) {
  Case c = MakeCase(kEqual, 3, 0.1, 1);
  // Overlapping, as a simulation leaves it; x outside of the periodic box.
  c.particles.packing = {{5, 1e-5, {0.9, 0, 2e-5}, {1, 2, 3}, {4, 5, 6}},
                         {2, 1e-5, {0.9, 0, 3.9e-5}, {}, {}}};
  const Packing packing = Place(c);
  ASSERT_EQ(packing.size(), 2u);
  EXPECT_EQ(packing[0].id, 5);
  EXPECT_EQ(packing[0].velocity, (Vector3{1, 2, 3}));
  EXPECT_EQ(packing[1].position[2], 3.9e-5);
}

TEST(PlaceParticles, ChecksAnExplicitPacking) {
  Case c = MakeCase(kEqual, 3, 0.1, 1);
  const Sphere good{1, 1e-5, {0, 0, 1e-4}, {}, {}};
  const auto error = [&](auto change) {
    Sphere bad = good;
    bad.id = 2;
    change(bad);
    c.particles.packing = {good, bad};
    return ErrorOf(c);
  };
  EXPECT_EQ(error([](Sphere&) {}), "no error");
  EXPECT_THAT(error([](Sphere& s) { s.position[2] = -1e-6; }), HasSubstr("z = -1e-06 m"));
  EXPECT_THAT(error([](Sphere& s) { s.radius = 0; }), HasSubstr("radius 0 m"));
  EXPECT_THAT(error([](Sphere& s) { s.velocity[0] = NAN; }), HasSubstr("not finite"));
  EXPECT_THAT(error([](Sphere& s) { s.id = 1; }), HasSubstr("twice"));
  EXPECT_THAT(error([](Sphere& s) { s.id = 0; }), HasSubstr("count from 1"));
  c.particles.packing = Packing();
  EXPECT_THAT(ErrorOf(c), HasSubstr("no particles"));
}

}  // namespace
}  // namespace powdercal
