#include <gtest/gtest.h>

#include "backends/embedded/simulation.h"
#include "backends/insertion.h"
#include "tests/physics/programs.h"

namespace powdercal::physics {
namespace {

using embedded::Simulation;

constexpr double kStress = 900;  // [Pa] along z
constexpr int kCount = 600;
constexpr double kStep = 5e-7;

// A cell of random spheres, Lees–Edwards shear under constant stress along z, I = 0.01.
class ShearedCell {
 public:
  explicit ShearedCell(int threads = 1) {
    const double solid = kCount * 4.0 / 3 * kPi * std::pow(kRadius, 3);
    const double edge = std::cbrt(solid / 0.30);
    program_ = Vacuum({}, kStep);
    program_.particles.packing.reset();
    program_.particles.sizes = {SizeDistribution::Kind::normal, 2 * kRadius, 3e-6, 20e-6, 40e-6};
    program_.particles.count = kCount;
    program_.particles.seed = 4;
    SetContact(program_, {.restitution = 0.4, .friction = 0.3});
    program_.domain = {{-0.5 * edge, -0.5 * edge, -0.5 * edge},
                       {0.5 * edge, 0.5 * edge, 0.5 * edge},
                       {Boundary::periodic, Boundary::periodic, Boundary::periodic}};
    const Packing packing = PlaceParticles(program_.particles, program_.domain,
                                           {.bottom = -0.5 * edge, .top = 0.5 * edge});
    simulation_.emplace(program_, packing,
                        embedded::Settings{.isa = embedded::BestIsa(), .threads = threads});
    embedded::CellDrive drive{.shear_rate = rate(), .pace = rate(), .gain = 3};
    drive.edges[2] = {EdgeControl::Kind::stress, kStress};
    simulation_->SetCellDrive(drive);
  }

  static double rate() { return 0.01 / (2 * kRadius * std::sqrt(kDensity / kStress)); }

  // Shears on by `strain`.
  void Shear(double strain) {
    simulation_->Run(static_cast<std::int64_t>(strain / (rate() * kStep)), nullptr);
    ASSERT_FALSE(simulation_->failure()) << simulation_->failure()->message;
  }

  Simulation& simulation() { return *simulation_; }
  const Program& program() const { return program_; }

 private:
  Program program_;
  std::optional<Simulation> simulation_;
};

struct Profile {
  static constexpr int kBins = 10;
  double own[kBins] = {};  // [m/s] sum of v_x less the affine velocity
  double count[kBins] = {};
};

TEST(ShearedCell, IsHomogeneous) {
  ShearedCell cell;
  Simulation& simulation = cell.simulation();
  cell.Shear(1.5);
  Profile profile;
  std::array<Vector3, 3> stress{};
  int samples = 0;
  simulation.after_step = [&] {
    if (!simulation.measured_cell()) return;
    for (std::size_t a = 0; a < 3; ++a) stress[a] = stress[a] + simulation.stress()[a];
    ++samples;
  };
  constexpr int kPieces = 60;
  for (int piece = 0; piece < kPieces; ++piece) {
    cell.Shear(0.05);
    const CellState state = simulation.Cell();
    const double height = state.upper[2] - state.lower[2];
    for (const Sphere& s : simulation.CurrentPacking()) {
      const auto bin = static_cast<std::size_t>(std::clamp(
          (s.position[2] - state.lower[2]) / height * Profile::kBins, 0.0, Profile::kBins - 1.0));
      const double own = s.velocity[0] - ShearedCell::rate() * s.position[2];
      profile.own[bin] += own;
      profile.count[bin] += 1;
    }
  }
  const Vector3 lengths = simulation.Cell().upper - simulation.Cell().lower;
  EXPECT_EQ(lengths[0], lengths[1]) << "x and y were not to change";

  // No layer is faster or slower than its share of the shear, those at the boundary neither.
  const double across = ShearedCell::rate() * lengths[2];
  double worst = 0;
  for (std::size_t b = 0; b < Profile::kBins; ++b) {
    worst = std::max(worst, std::abs(profile.own[b] / profile.count[b]) / across);
  }
  Measured("largest departure from the linear profile, over the velocity across", worst);
  EXPECT_LT(worst, 0.02);
  const double jump =
      (profile.own[0] / profile.count[0] - profile.own[9] / profile.count[9]) / across;
  Measured("jump across the boundary", jump);
  EXPECT_LT(std::abs(jump), 0.02);

  for (Vector3& row : stress) row = (1.0 / samples) * row;
  Measured("relative error of the stress along z", stress[2][2] / kStress - 1);
  Measured("asymmetry of the stress, over the shear stress", stress[0][2] / stress[2][0] - 1);
  Measured("friction coefficient of the flow", -stress[0][2] / stress[2][2]);
  EXPECT_NEAR(stress[2][2] / kStress, 1, 0.02);
  EXPECT_NEAR(stress[0][2] / stress[2][0], 1, 0.03);
  for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2)}) {
    EXPECT_NEAR(stress[a][b] / kStress, stress[b][a] / kStress, 0.02);
    EXPECT_NEAR(stress[a][b] / kStress, 0, 0.05);
  }
  // Equal spheres with mu = 0.3 flow at tan 19 to 20 degrees.
  EXPECT_NEAR(-stress[0][2] / stress[2][2], 0.36, 0.04);
}

// The solid fraction of the flow follows from the lengths that the trace gives.
TEST(ShearedCell, TraceHoldsTheVolume) {
  ShearedCell cell;
  Program program = cell.program();
  Deform shear{
      .name = "shear", .duration = 2 / ShearedCell::rate(), .shear_rate = ShearedCell::rate()};
  shear.edges[2] = {EdgeControl::Kind::stress, kStress};
  const Vector3 edges = program.domain.Lengths();
  program.stages = {Insert{-0.5 * edges[2], 0.5 * edges[2], {}}, shear};
  const Trace trace = RunOk(program);
  const CellSeries& series = trace.cell;
  ASSERT_GT(series.time.size(), 100U);
  ASSERT_EQ(series.lengths.size(), series.time.size());
  ASSERT_EQ(series.stress.size(), series.time.size());
  EXPECT_NEAR(series.strain.back(), 2, 0.01);
  const CellState& state = *trace.moments.back().cell;
  double solid = 0;
  for (const Sphere& s : trace.moments.back().packing) {
    solid += 4.0 / 3 * kPi * s.radius * s.radius * s.radius;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_GE(s.position[axis], state.lower[axis]);
      EXPECT_LE(s.position[axis], state.upper[axis]);
    }
  }
  const Vector3 lengths = state.upper - state.lower;
  EXPECT_NEAR(series.lengths.back()[2] / lengths[2], 1, 1e-3);
  const double fraction = solid / (lengths[0] * lengths[1] * lengths[2]);
  Measured("solid fraction in shear", fraction);
  EXPECT_NEAR(fraction, 0.60, 0.02);
}

// From one stress to another while the shear goes on; stages end between two samples of the stress.
TEST(ShearedCell, FollowsAStressThatChangesFromStageToStage) {
  ShearedCell cell;
  Program program = cell.program();
  const Vector3 edges = program.domain.Lengths();
  program.stages = {Insert{-0.5 * edges[2], 0.5 * edges[2], {}}};
  const auto shear = [&](const std::string& name, double stress, double strain) {
    Deform stage{.name = name,
                 .duration = strain / ShearedCell::rate() + 7 * kStep,
                 .shear_rate = ShearedCell::rate()};
    stage.edges[2] = {EdgeControl::Kind::stress, stress};
    program.stages.push_back(stage);
  };
  shear("900", 900, 1);
  shear("300", 300, 0.5);
  shear("600", 600, 0.5);
  shear("600 still", 600, 0.5);
  const Trace trace = RunOk(program);
  ASSERT_EQ(trace.moments.size(), 4U);
  const CellSeries& series = trace.cell;
  for (std::size_t m = 1; m < 4; ++m) {
    const double begin = trace.moments[m - 1].time;
    const double end = trace.moments[m].time;
    const double target = m == 1 ? 300 : 600;
    double least = 1e9;
    double most = 0;
    double mean = 0;
    int count = 0;
    double settled = 0;
    for (std::size_t n = 0; n < series.time.size(); ++n) {
      if (series.time[n] <= begin || series.time[n] > end) continue;
      const double stress = series.stress[n][2][2] / target;
      least = std::min(least, stress);
      most = std::max(most, stress);
      if (settled == 0 && std::abs(stress - 1) < 0.2) settled = series.time[n] - begin;
      if (series.time[n] < begin + 0.2 * (end - begin)) continue;
      mean += stress;
      ++count;
    }
    const std::string& name = trace.moments[m].name;
    Measured("least stress, " + name, least);
    Measured("largest stress, " + name, most);
    Measured("strain until within 20 %, " + name, settled * ShearedCell::rate());
    Measured("mean error of the stress, " + name, mean / count - 1);
    EXPECT_GT(least, m == 3 ? 0.9 : 0.4) << name;
    EXPECT_LT(most, 1.2) << name;
    EXPECT_LT(settled * ShearedCell::rate(), 0.05) << name;
    EXPECT_NEAR(mean / count, 1, 0.01) << name;
  }
}

}  // namespace
}  // namespace powdercal::physics
