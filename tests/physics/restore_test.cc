#include "tests/physics/detours.h"

namespace powdercal::physics {
namespace {

TEST(Restore, CellGoesOnAsIfNothingHadHappened) {
  const Trace trace = ExpectSameAfterDetour(ShearedCell(), CellDetour(), {embedded::BestIsa(), 1});
  EXPECT_NEAR(trace.cell.strain.back(), 1.5e-3 * 200, 1e-9) << "the detour's strain is undone";
}

TEST(Restore, BedGoesOnAsIfNothingHadHappened) {
  const Trace trace = ExpectSameAfterDetour(LoadedBed(), BedDetour(), {embedded::BestIsa(), 1});
  const Moment& end = trace.moments.back();
  EXPECT_GT(end.walls.at("lid").force[2], 0);
  EXPECT_NE(end.walls.at("right").force[0], 0) << "the wall is back";
  EXPECT_FALSE(trace.Find("detour")->walls.contains("right"));
}

// Any number of times, and to any state.
TEST(Restore, StatesServeAgain) {
  Program program = ShearedCell();
  const auto branch = std::get<Deform>(program.stages.back());
  program.stages.pop_back();
  const auto named = [&](const std::string& name) {
    Deform stage = branch;
    stage.name = name;
    return stage;
  };
  const std::vector<Stage> branches = {Save{"a"},    named("first"),  Save{"b"},    named("next"),
                                       Restore{"a"}, named("again"),  Restore{"b"}, named("next 2"),
                                       Restore{"a"}, named("again 2")};
  program.stages.insert(program.stages.end(), branches.begin(), branches.end());
  const Trace trace = RunOn(program, {embedded::BestIsa(), 1});
  const auto expect_same = [&](const std::string& a, const std::string& b) {
    Trace one;
    one.moments = {*trace.Find(a)};
    Trace other;
    other.moments = {*trace.Find(b)};
    ExpectIdentical(one, other);
  };
  expect_same("first", "again");
  expect_same("first", "again 2");
  expect_same("next", "next 2");
}

}  // namespace
}  // namespace powdercal::physics
