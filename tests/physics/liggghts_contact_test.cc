#include "tests/physics/collisions.h"
#include "tests/physics/two_engines.h"

// A dozen collisions far apart from one another, in one run of each engine, for every law that both
// have; compared frame by frame.

namespace powdercal::physics {
namespace {

using Normal = ContactLaw::Normal;
using Tangential = ContactLaw::Tangential;
using Cohesion = ContactLaw::Cohesion;
using Rolling = ContactLaw::Rolling;

Scene Collisions(const ContactLaw& law) {
  Scene scene(law.cohesion == Cohesion::dmt);
  const double v = kSpeed;
  const double w = kSpin;
  const double gap = 1e-3 * kRadius;
  const double overlap = -0.02 * kRadius;
  const double slow = 0.1 * v;
  scene.Pair("head-on", 1, gap, {1, 0, 0}, {v, 0, 0}, {-v, 0, 0});
  scene.Pair("nearly head-on", 1, gap, {1, 2, 3}, {v / 3, v / 2, v}, {});
  scene.Pair("oblique", 1, gap, {1, 0, 0}, {v, 0, 0.7 * v}, {-v, 0, 0});
  scene.Pair("grazing", 1.5, gap, {0, 1, 0}, {2 * v, 0.3 * v, v}, {0, -0.3 * v, 0});
  scene.Pair("rolling", 1, gap, {0, 0, 1}, {0, 0, v}, {0, 0, -v}, {w, 0, 0}, {-w, 0, 0});
  scene.Pair("sliding spins", 2, gap, {0, 1, 1}, {0, v, v}, {}, {2 * w, w, 0}, {2 * w, -w, 0});
  scene.Pair("twisting", 1, gap, {1, 1, 0}, {v, v, 0}, {}, {3 * w, 3 * w, 0}, {-w, -w, 0});
  scene.Pair("all at once", 3, gap, {-1, 2, 1}, {-v, v, 0.2 * v}, {v, 0, -v}, {w, -2 * w, w},
             {0, 3 * w, 0.5 * w});
  scene.Pair("small on large", 3, gap, {1, -1, 2}, {}, {-v, 2 * v, -v}, {0, 0, 2 * w}, {w, 0, 0});
  scene.Pair("touching, rolling", 1, gap, {0, 1, 0}, {0, slow, 0}, {}, {w, 0, 0}, {-w, 0, 0});
  scene.Pair("touching, twisting", 1.5, gap, {1, 0, 0}, {slow, 0, 0}, {}, {w, 0, 0},
             {-w, 0.1 * w, 0});
  scene.Pair("pressed, let go", 1, overlap, {0, 0, 1}, {}, {});
  scene.Pair("pressed, pulled off", 2, overlap, {1, 0, 0}, {}, {0.5 * v, 0, 0});
  scene.Pair("pressed, sheared", 2.5, overlap, {0, 0, 1}, {0.1 * v, 0, 0}, {});

  for (const std::size_t axis : {0U, 1U, 2U}) {
    for (const int side : {-1, 1}) {
      const std::string plane = std::string(side < 0 ? "lower " : "upper ") + "xyz"[axis];
      Vector3 velocity{};
      velocity[axis] = side * v;
      velocity[(axis + 1) % 3] = 0.6 * v;
      velocity[(axis + 2) % 3] = -0.2 * v;
      scene.AtWall("plane " + plane + ", oblique", axis, side, 1, gap, velocity, {});
      velocity[(axis + 1) % 3] = 0;
      Vector3 spin = {0.4 * w, 0.5 * w, -0.6 * w};
      spin[axis] = 2 * w;
      scene.AtWall("plane " + plane + ", spinning", axis, side, 2, gap, velocity, spin);
      spin[axis] = 0.1 * w;
      velocity = {};
      velocity[axis] = side * slow;
      scene.AtWall("plane " + plane + ", rolling", axis, side, 1, gap, velocity, spin);
    }
  }
  // Not with cdt: see CdtInTwoEngines.
  if (law.rolling != Rolling::cdt) scene.Pair("pressed, tilted", 2, overlap, {1, 0, 1}, {}, {});
  return scene;
}

void ExpectSameTrajectories(const Program& program, const Scene& scene, double tolerance,
                            double spin_tolerance) {
  const TwoTraces traces = RunBoth(program);
  ASSERT_TRUE(traces.embedded.outcome.ok()) << traces.embedded.outcome.message;
  ASSERT_TRUE(traces.liggghts.outcome.ok()) << traces.liggghts.outcome.message;
  ASSERT_EQ(traces.embedded.moments.size(), traces.liggghts.moments.size());
  ASSERT_EQ(traces.embedded.moments.size(), static_cast<std::size_t>(kFrames));
  ExpectContacts(program, scene, traces.liggghts.moments);
  const auto differences = Compare(traces.embedded.moments, traces.liggghts.moments, scene);
  Difference worst;
  for (const auto& [name, d] : differences) {
    EXPECT_LT(d.position, tolerance) << name;
    EXPECT_LT(d.velocity, tolerance) << name;
    EXPECT_LT(d.spin, spin_tolerance) << name;
    worst.position = std::max(worst.position, d.position);
    worst.velocity = std::max(worst.velocity, d.velocity);
    worst.spin = std::max(worst.spin, d.spin);
  }
  std::printf("[ row ] | %s | %.1e | %.1e | %.1e |\n", program.law.ToString().c_str(),
              worst.position, worst.velocity, worst.spin);
}

std::vector<ContactLaw> Laws() {
  std::vector<ContactLaw> laws;
  for (const Normal normal : {Normal::hertz, Normal::linear}) {
    for (const Tangential tangential : {Tangential::history, Tangential::no_history}) {
      for (const Cohesion cohesion : {Cohesion::none, Cohesion::sjkr2, Cohesion::dmt}) {
        for (const Rolling rolling : {Rolling::none, Rolling::cdt, Rolling::epsd2}) {
          for (const bool limit : {false, true}) {
            for (const bool torsion : {true, false}) {
              if (rolling == Rolling::none && !torsion) continue;
              laws.push_back({.normal = normal,
                              .limit_force = limit,
                              .tangential = tangential,
                              .cohesion = cohesion,
                              .rolling = rolling,
                              .torsion = torsion});
            }
          }
        }
      }
      for (const Cohesion cohesion : {Cohesion::sjkr2, Cohesion::dmt}) {
        for (const Rolling rolling : {Rolling::none, Rolling::cdt, Rolling::epsd2}) {
          laws.push_back({.normal = normal,
                          .tangential = tangential,
                          .cohesion = cohesion,
                          .rolling = rolling,
                          .tangential_reduce = true});
        }
      }
    }
  }
  return laws;
}

std::string NameOf(const ::testing::TestParamInfo<ContactLaw>& info) {
  const ContactLaw& law = info.param;
  const auto name = [](std::span<const std::string> names, auto value) {
    return names[static_cast<std::size_t>(value)];
  };
  std::string text = name(NormalLawNames(), law.normal) + "_" +
                     name(TangentialLawNames(), law.tangential) + "_" +
                     name(CohesionNames(), law.cohesion) + "_" + name(RollingNames(), law.rolling);
  if (law.rolling != Rolling::none) text += law.torsion ? "_torsion" : "_no_torsion";
  text += law.limit_force ? "_limited" : "";
  return text + (law.tangential_reduce ? "_reduced" : "");
}

class ContactsInTwoEngines : public ::testing::TestWithParam<ContactLaw> {};

TEST_P(ContactsInTwoEngines, MoveAlike) {
  const Scene scene = Collisions(GetParam());
  ExpectSameTrajectories(SceneProgram(GetParam(), scene.packing()), scene, 1e-9, 1e-9);
}

// The law of the seed paper. A sphere at rest chatters under cdt: in every step its spin jumps by
// mu_r r F dt/I, which is 4e-4 of the scale on the lower z plane where cohesion is weak, and
// rounding decides about some of the jumps.
TEST(PaperLawInTwoEngines, MovesAlike) {
  for (const double cohesion : {5000.0, 47'500.0}) {
    for (const Tangential tangential : {Tangential::no_history, Tangential::history}) {
      const ContactLaw law = {
          .tangential = tangential, .cohesion = Cohesion::sjkr2, .rolling = Rolling::cdt};
      const Scene scene = Collisions(law);
      Program program = SceneProgram(law, scene.packing());
      SetContact(program, {.restitution = 0.4,
                           .friction = 0.3,
                           .rolling_friction = 0.5,
                           .cohesion_energy_density = cohesion});
      ExpectSameTrajectories(program, scene, 1e-4, 1e-3);
    }
  }
}

// Without spin the direction of cdt's torque is that of a rounding error, and its size is not
// small. LIGGGHTS then does not agree with itself once everything is moved to another place.
TEST(CdtInTwoEngines, RoundingDecidesWhereNothingSpins) {
  std::vector<Packing> ends;
  for (const double place : {0.0, 1.1e-5}) {
    const double along = 0.98 * 1.5 * kRadius / std::sqrt(2.0);
    Program program =
        InBox({Ball(1, kRadius, {place, 0, 0}), Ball(2, 0.5 * kRadius, {place + along, 0, along})});
    program.law.rolling = Rolling::cdt;
    SetContact(program, {.restitution = 0.5, .friction = 0.3, .rolling_friction = 0.15});
    program.stages = {Advance{.duration = 2e-4}};
    const Trace trace = RunLiggghts(program);
    ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
    ends.push_back(trace.moments.back().packing);
  }
  const double speed = Length(ends[0][1].velocity);
  const double difference = Length(ends[0][1].velocity - ends[1][1].velocity) / speed;
  Measured("velocity of LIGGGHTS against its own elsewhere", difference);
  EXPECT_GT(difference, 1e-6);
}

// Pairs that meet across the sides and the edge of a box that is periodic in x and y.
TEST(ContactsAcrossPeriodicSides, MoveAlike) {
  const double half = 1.1 * kHalfBox;
  const double v = kSpeed;
  const double w = kSpin;
  const double r = kRadius;
  Program program =
      InBox({Ball(1, r, {half - 0.6 * r, 0, 0}, {v, 0, 0.4 * v}, {0, w, 0}),
             Ball(2, r, {-half + 1.41 * r, 0, 0}, {-v, 0, 0}, {w, w, 0}),
             Ball(3, r, {half - 0.7 * r, half - 0.7 * r, 0}, {v, v, 0}, {0, 0, w}),
             Ball(4, r / 2, {-half + 0.37 * r, -half + 0.37 * r, 0}, {0, -v, v}, {w, 0, w})});
  program.domain.boundaries = {Boundary::periodic, Boundary::periodic, Boundary::open};
  program.law.cohesion = Cohesion::sjkr2;
  program.law.rolling = Rolling::epsd2;
  SetContact(program, {.restitution = 0.6,
                       .friction = 0.3,
                       .rolling_friction = 0.2,
                       .cohesion_energy_density = 10'000});
  program.stages = {
      Advance{.duration = kEvery * kFrames * program.time_step, .packing_every = kEvery}};
  const TwoTraces traces = RunBoth(program);
  ASSERT_TRUE(traces.liggghts.outcome.ok()) << traces.liggghts.outcome.message;
  ASSERT_EQ(traces.embedded.moments.size(), traces.liggghts.moments.size());
  double worst = 0;
  for (std::size_t frame = 0; frame < traces.embedded.moments.size(); ++frame) {
    for (std::size_t n = 0; n < 4; ++n) {
      const Sphere& p = traces.embedded.moments[frame].packing[n];
      const Sphere& q = traces.liggghts.moments[frame].packing[n];
      Vector3 apart = p.position - q.position;
      for (double& x : apart) x -= 2 * half * std::round(x / (2 * half));
      worst = std::max({worst, Length(apart) / r, Length(p.velocity - q.velocity) / v,
                        r * Length(p.spin - q.spin) / v});
    }
  }
  Measured("across periodic sides", worst);
  EXPECT_LT(worst, 1e-9);
  const Packing& end = traces.liggghts.moments.back().packing;
  for (std::size_t n = 0; n < 4; ++n) {
    const Sphere& start = (*program.particles.packing)[n];
    EXPECT_GT(Length(end[n].velocity - start.velocity), 0.1 * v) << "no collision of " << n + 1;
  }
}

// LIGGGHTS begins with a look at the forces, in which the torque of epsd2 is that of a spring which
// has gone on by a step, though it is not kept. The embedded engine's has not. That makes a
// difference of half a step's torque to contacts that roll from the start: none of those above.
TEST(RollingSpringsInTwoEngines, DifferByHalfAStepAtTheStart) {
  const double overlap = 0.02 * kRadius;
  const double w = 0.1 * kSpin;
  const double reach = kRadius - 0.5 * overlap;
  Program program = InBox({Ball(1, kRadius, {-reach, 0, 0}, {}, {0, w, 0}),
                           Ball(2, kRadius, {reach, 0, 0}, {}, {0, -w, 0})});
  program.law.rolling = Rolling::epsd2;
  SetContact(program, {.restitution = 1, .rolling_friction = 10});
  program.stages = {Advance{.duration = program.time_step}};
  const TwoTraces traces = RunBoth(program);
  ASSERT_TRUE(traces.liggghts.outcome.ok()) << traces.liggghts.outcome.message;
  const double embedded = traces.embedded.moments.back().packing[0].spin[1];
  const double liggghts = traces.liggghts.moments.back().packing[0].spin[1];
  // The spring's stiffness over the moment of inertia, times dt².
  const double radius = kRadius / 2;
  const double kick = 8 * EffectiveShear() * std::sqrt(radius * overlap) * radius * radius /
                      InertiaOf(kRadius) * program.time_step * program.time_step;
  EXPECT_GT(kick, 1e-4);
  EXPECT_NEAR(embedded - w, -kick * w, 1e-3 * kick * w);
  EXPECT_NEAR((liggghts - embedded) / (kick * w), -1 + kick, 1e-3);
}

// Else there would be less to the agreement than it seems.
TEST(ContactsOfTheScene, TellAllLawsApart) {
  const std::vector<ContactLaw> laws = Laws();
  std::vector<Packing> ends;
  for (const ContactLaw& law : laws) {
    ends.push_back(RunOk(SceneProgram(law, Collisions(law).packing())).moments.back().packing);
  }
  for (std::size_t a = 0; a < laws.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      double difference = 0;
      for (std::size_t n = 0; n < std::min(ends[a].size(), ends[b].size()); ++n) {
        const Sphere& p = ends[a][n];
        const Sphere& q = ends[b][n];
        difference = std::max(difference,
                              Length(p.velocity - q.velocity) + p.radius * Length(p.spin - q.spin));
      }
      EXPECT_GT(difference, 1e-3 * kSpeed) << laws[a].ToString() << "; " << laws[b].ToString();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Liggghts, ContactsInTwoEngines, ::testing::ValuesIn(Laws()), NameOf);

}  // namespace
}  // namespace powdercal::physics
