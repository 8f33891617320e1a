#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "backends/embedded/mesh_shapes.h"
#include "backends/embedded/stages.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {

using embedded::Isa;

struct Way {
  Isa isa;
  int threads;
};

/// The portable code on one thread first: what the others are held against.
inline std::vector<Way> OneThread() {
  std::vector<Way> ways;
  for (const Isa isa : {Isa::portable, Isa::avx2, Isa::avx512}) {
    if (embedded::Has(isa)) ways.push_back({isa, 1});
  }
  return ways;
}

inline std::vector<Way> Threads() {
  return {{embedded::BestIsa(), 1},
          {embedded::BestIsa(), 2},
          {embedded::BestIsa(), 3},
          {Isa::portable, 3}};
}

inline void ExpectIdentical(const Trace& a, const Trace& b) {
  ASSERT_EQ(a.moments.size(), b.moments.size());
  for (std::size_t m = 0; m < a.moments.size(); ++m) {
    const Packing& p = a.moments[m].packing;
    const Packing& q = b.moments[m].packing;
    ASSERT_EQ(p.size(), q.size());
    for (std::size_t n = 0; n < p.size(); ++n) {
      ASSERT_EQ(p[n].id, q[n].id);
      ASSERT_EQ(p[n].position, q[n].position) << "particle " << p[n].id;
      ASSERT_EQ(p[n].velocity, q[n].velocity) << "particle " << p[n].id;
      ASSERT_EQ(p[n].spin, q[n].spin) << "particle " << p[n].id;
    }
    const auto& c = a.moments[m].contacts;
    const auto& d = b.moments[m].contacts;
    ASSERT_EQ(c.size(), d.size());
    for (std::size_t n = 0; n < c.size(); ++n) {
      ASSERT_EQ(c[n].i, d[n].i);
      ASSERT_EQ(c[n].j, d[n].j);
      ASSERT_EQ(c[n].shear, d[n].shear);
      ASSERT_EQ(c[n].rolling, d[n].rolling);
    }
    for (const auto& [name, wall] : a.moments[m].walls) {
      ASSERT_EQ(wall.force, b.moments[m].walls.at(name).force) << name;
      ASSERT_EQ(wall.displacement, b.moments[m].walls.at(name).displacement) << name;
    }
  }
  EXPECT_EQ(a.cell.stress, b.cell.stress);
  EXPECT_EQ(a.slab.stress, b.slab.stress);
  ASSERT_EQ(a.series.size(), b.series.size());
  for (std::size_t n = 0; n < a.series.size(); ++n) {
    EXPECT_EQ(a.series[n].force, b.series[n].force) << a.series[n].wall;
  }
}

inline void ExpectTheSame(const Program& program, const std::vector<Way>& ways) {
  std::optional<Trace> first;
  for (const Way& way : ways) {
    SCOPED_TRACE(fmt::format("{}, {} threads",
                             embedded::IsaNames()[static_cast<std::size_t>(way.isa)], way.threads));
    const RunContext context;
    const Trace trace =
        embedded::StageRunner(program, context, {.isa = way.isa, .threads = way.threads}).Run();
    ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
    if (!first) {
      first = trace;
      continue;
    }
    ExpectIdentical(*first, trace);
  }
}

inline Program Grains(int count, const ContactLaw::Rolling rolling) {
  Program program = Vacuum({}, 5e-7);
  program.particles.packing.reset();
  program.particles.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 6e-6, 12.5e-6, 37.5e-6};
  program.particles.count = count;
  program.particles.seed = 7;
  program.law.cohesion = ContactLaw::Cohesion::sjkr2;
  program.law.rolling = rolling;
  SetContact(program, {.restitution = 0.4,
                       .friction = 0.3,
                       .rolling_friction = 0.4,
                       .cohesion_energy_density = 15833});
  return program;
}

/// 2000 spheres poured between walls on a ridged mesh, loaded, and sheared by the mesh.
inline Program Bed(double duration) {
  Program program = Grains(2000, ContactLaw::Rolling::epsd2);
  const double width = 20 * kRadius;
  program.domain = {{-width, -0.5 * width, -kRadius},
                    {width, 0.5 * width, 120 * kRadius},
                    {Boundary::open, Boundary::periodic, Boundary::open}};
  program.gravity = {0, 0, -kGravity};
  program.walls = {{.name = "left", .axis = 0, .position = -width},
                   {.name = "right", .axis = 0, .position = width, .facing_positive = false},
                   {.name = "lid", .position = 110 * kRadius, .facing_positive = false}};
  program.meshes = {embedded::MakeRidgedPlate("floor", {-width, -0.5 * width, 0}, 2 * width, width,
                                              4 * kRadius, kRadius, 4)};
  program.stress_slab = {{0, 15 * kRadius}};
  program.stages = {
      Insert{kRadius, 80 * kRadius, {0.1, 0.05, -0.5}},
      Advance{.name = "pour", .duration = 0.5 * duration, .packing_every = 250},
      Servo{"lid", 900, 0.5, 0.25 * duration},
      Advance{.duration = 0.25 * duration, .motions = {{"floor", {0.05, 0, 0}, {}, {}}}}};
  return program;
}

/// 1000 spheres in a cell that is sheared and compressed.
inline Program Cell(ContactLaw::Rolling rolling, double duration) {
  Program program = Grains(1000, rolling);
  const double edge = 24 * kRadius;
  program.domain = {{-0.5 * edge, -0.5 * edge, -0.5 * edge},
                    {0.5 * edge, 0.5 * edge, 0.5 * edge},
                    {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
  Deform shear{.duration = duration, .shear_rate = 200};
  shear.edges[0] = {EdgeControl::Kind::strain_rate, -100};
  shear.edges[1] = {EdgeControl::Kind::strain_rate, -100};
  shear.edges[2] = {EdgeControl::Kind::stress, 900};
  program.stages = {Insert{-0.5 * edge, 0.5 * edge, {}}, shear};
  return program;
}

}  // namespace powdercal::physics
