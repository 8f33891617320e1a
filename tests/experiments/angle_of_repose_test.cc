#include "experiments/angle_of_repose.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "backends/registry.h"
#include "tests/experiments/powder_samples.h"

namespace powdercal {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

AngleOfRepose With(const std::string& options) { return WithOptions<AngleOfRepose>(options); }

std::string Removed(const Program& program) {
  for (const Stage& stage : program.stages) {
    if (const auto* remove = std::get_if<Remove>(&stage)) return remove->body;
  }
  return "";
}

TEST(AngleOfRepose, BedStandsBetweenBackWallAndGate) {
  const Program program = PlanOf(With("method: draw_down"), MetalPowder());
  EXPECT_EQ(Removed(program), "gate");
  const double gate = program.walls[2].position;
  EXPECT_LT(LargestOverlap(*program.particles.packing, program.domain.upper[1]), 1e-15);
  for (const Sphere& sphere : *program.particles.packing) {
    EXPECT_GE(sphere.position[0], sphere.radius);
    EXPECT_LE(sphere.position[0], gate - sphere.radius);
  }
  EXPECT_EQ(program.domain.boundaries[0], Boundary::outflow);
  EXPECT_NEAR(program.domain.upper[0] - gate, program.particles.sizes.Moment(1) / 2, 1e-12);
}

TEST(AngleOfRepose, PowderStandsInTheFunnelAboveThePlug) {
  for (const Fidelity fidelity : {Fidelity::quick, Fidelity::standard}) {
    const Program program = PlanOf(With("method: funnel"), MetalPowder(), fidelity);
    EXPECT_EQ(Removed(program), "plug");
    const double d = program.particles.sizes.Moment(1);
    const double radius = fidelity == Fidelity::quick ? 7 * d : 11 * d;
    const double inside = radius * std::cos(std::numbers::pi / 24);
    double top = 0;
    for (const Mesh& mesh : program.meshes) {
      for (const Vector3& vertex : mesh.vertices) top = std::max(top, vertex[2]);
    }
    for (const Sphere& sphere : *program.particles.packing) {
      const auto& [x, y, z] = sphere.position;
      EXPECT_LT(std::hypot(x, y) + sphere.radius, inside);
      EXPECT_GT(z, 7 * d);
      EXPECT_LT(z + sphere.radius, top);
    }
  }
}

TEST(AngleOfRepose, ResponsesBelongToTheMethod) {
  const auto names = [](const std::string& options) {
    std::vector<std::string> list;
    const AngleOfRepose experiment = With(options);
    for (const auto& response : experiment.responses()) list.push_back(response.name);
    return list;
  };
  EXPECT_THAT(names("{}"), testing::ElementsAre("angle", "poured_void_ratio", "retained_mass"));
  EXPECT_THAT(names("method: funnel"),
              testing::ElementsAre("angle", "discharged_share", "retained_mass"));
}

TEST(AngleOfRepose, RefusesBadOptions) {
  EXPECT_THROW(With("method: drum"), InputError);
  EXPECT_THROW(With("outlet: 8"), InputError) << "the draw-down has none";
  EXPECT_THROW(With("{method: funnel, bed_aspect: 0.5}"), InputError);
  EXPECT_THROW(With("flow_time: 0 s"), InputError);
}

TEST(AngleOfRepose, RefusesWhatNoHeapComesOf) {
  SimulatedPowder powder = MetalPowder();
  EXPECT_EQ(With("{}").ExplainUnsupported(powder), "");
  powder.law.tangential = ContactLaw::Tangential::no_history;
  EXPECT_THAT(With("{}").ExplainUnsupported(powder), testing::HasSubstr("tangential"));
  EXPECT_THROW(PlanOf(With("{}"), powder), InputError);
  EXPECT_THAT(With("{method: funnel, outlet: 2}").ExplainUnsupported(MetalPowder()),
              testing::HasSubstr("outlet"));
}

// Equal spheres that fill the bed up to a surface, closely enough for it to be smooth.
Packing Filled(const Program& program, const std::function<double(double)>& surface) {
  const double r = 14.5e-6;
  const double step = r / 2;
  Packing packing;
  for (double x = step / 2; x < program.domain.upper[0]; x += step) {
    const double top = surface(x) - r;
    if (top < 0) continue;
    for (double y = step / 2; y < program.domain.upper[1]; y += step) {
      packing.push_back({.id = static_cast<std::int64_t>(packing.size()) + 1,
                         .radius = r,
                         .position = {x, y, top}});
    }
  }
  return packing;
}

Trace Flowed(const Program& program, const std::function<double(double)>& surface) {
  Trace trace;
  trace.moments.push_back({.name = "settle", .packing = *program.particles.packing});
  trace.moments.push_back({.name = "settle", .time = 0.05, .packing = Filled(program, surface)});
  return trace;
}

TEST(AngleOfRepose, MeasuresAKnownSlope) {
  const AngleOfRepose repose = With("{}");
  const Program program = PlanOf(repose, EqualSpheres());
  const double edge = program.domain.upper[0];
  for (const double degrees : {20.0, 32.0, 50.0}) {
    const double slope = std::tan(degrees * kDegree);
    Outcome outcome;
    const Measurement measured = repose.Measure(
        program,
        Flowed(program, [&](double x) { return std::min(0.8 * edge, 15e-6 + (edge - x) * slope); }),
        &outcome);
    ASSERT_TRUE(outcome.ok()) << outcome.message;
    EXPECT_NEAR(measured.responses.at("angle").value / kDegree, degrees, 1.5);
    EXPECT_EQ(measured.diagnostics.at("cliff"), 0);
    EXPECT_EQ(measured.diagnostics.at("at_rest"), 1);
  }
}

TEST(AngleOfRepose, FaceHeldUpByCohesionIsACliffWithAnAngle) {
  const AngleOfRepose repose = With("{}");
  const Program program = PlanOf(repose, EqualSpheres());
  Outcome outcome;
  const Measurement measured =
      repose.Measure(program, Flowed(program, [](double) { return 11 * 29e-6; }), &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_EQ(measured.diagnostics.at("cliff"), 1);
  EXPECT_EQ(measured.diagnostics.at("angle_is_bound"), 1);
  EXPECT_GT(measured.responses.at("angle").value, 75 * kDegree);
}

TEST(AngleOfRepose, WhereNothingStaysThereIsNoAngle) {
  const AngleOfRepose repose = With("{}");
  const Program program = PlanOf(repose, EqualSpheres());
  Outcome outcome;
  const Measurement measured =
      repose.Measure(program, Flowed(program, [](double) { return 0; }), &outcome);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(measured.diagnostics.at("no_face"), 1);
  EXPECT_FALSE(measured.responses.contains("angle"));
  EXPECT_EQ(measured.responses.at("retained_mass").value, 0);
  EXPECT_GT(measured.responses.at("poured_void_ratio").value, 1) << "as it was placed";
}

TEST(AngleOfRepose, MeasuresAKnownCone) {
  const AngleOfRepose repose = With("method: funnel");
  const Program program = PlanOf(repose, EqualSpheres());
  const double r = 14.5e-6;
  const double plate = 14 * r;
  Trace trace;
  trace.moments.push_back({.name = "settle", .packing = *program.particles.packing});
  Moment end{.name = "settle", .time = 0.05};
  for (double x = -plate; x < plate; x += r / 2) {
    for (double y = -plate; y < plate; y += r / 2) {
      const double distance = std::hypot(x, y);
      if (distance > plate - r) continue;
      const double top = 2 * r + (plate - distance) * std::tan(30 * kDegree);
      end.packing.push_back({.id = static_cast<std::int64_t>(end.packing.size()) + 1,
                             .radius = r,
                             .position = {x, y, top - r}});
    }
  }
  trace.moments.push_back(std::move(end));
  Outcome outcome;
  const Measurement measured = repose.Measure(program, trace, &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_NEAR(measured.responses.at("angle").value / kDegree, 30, 2.5);
  EXPECT_EQ(measured.responses.at("discharged_share").value, 1);
}

TEST(AngleOfRepose, TraceWithoutBothPackingsIsACrash) {
  const AngleOfRepose repose = With("{}");
  const Program program = PlanOf(repose, EqualSpheres());
  Trace trace;
  trace.moments.push_back({.name = "settle"});
  Outcome outcome;
  repose.Measure(program, trace, &outcome);
  EXPECT_EQ(outcome.reason, Reason::crashed);
}

TEST(AngleOfRepose, DrawnDownBedKeepsASlope) {
  const AngleOfRepose repose = With("{bed_aspect: 0.5, flow_time: 20 ms}");
  const Program program = PlanOf(repose, EqualSpheres());
  const Trace trace = MakeBackend("embedded")->Run(program, {});
  ASSERT_TRUE(trace.outcome.ok()) << trace.outcome.message;
  Outcome outcome;
  const Measurement measured = repose.Measure(program, trace, &outcome);
  ASSERT_TRUE(outcome.ok()) << outcome.message;
  EXPECT_GT(measured.responses.at("retained_mass").value, 0.5);
  EXPECT_LT(measured.responses.at("retained_mass").value, 1);
  EXPECT_GT(measured.responses.at("angle").value, 15 * kDegree);
  EXPECT_LT(measured.responses.at("angle").value, 50 * kDegree);
  EXPECT_GT(measured.responses.at("poured_void_ratio").value, 0.55);
  EXPECT_LT(measured.responses.at("poured_void_ratio").value, 0.9);
}

}  // namespace
}  // namespace powdercal
