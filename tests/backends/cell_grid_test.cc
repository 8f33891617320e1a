#include "backends/cell_grid.h"

#include <gtest/gtest.h>

#include <map>

namespace powdercal {
namespace {

std::map<std::pair<std::size_t, Vector3>, int> Neighbours(const CellGrid& grid,
                                                          const Vector3& point) {
  std::map<std::pair<std::size_t, Vector3>, int> seen;
  grid.AnyNeighbour(grid.CellOf(point), [&](std::size_t index, const Vector3& shift) {
    ++seen[{index, shift}];
    return false;
  });
  return seen;
}

TEST(CellGrid, VisitsEachNeighbourOnce) {
  const CellGrid grid({0, 0, 0}, {5, 4, 3}, {true, true, false}, 1, 1000);
  EXPECT_EQ(grid.size(), 60u);
  for (const Vector3& point : {Vector3{2.5, 1.5, 1.5}, Vector3{0.1, 3.9, 1.5}}) {
    const auto seen = Neighbours(grid, point);
    EXPECT_EQ(seen.size(), 27u);
    for (const auto& [key, count] : seen) EXPECT_EQ(count, 1);
  }
  EXPECT_EQ(Neighbours(grid, {2.5, 1.5, 0.5}).size(), 18u);  // z is not periodic
}

TEST(CellGrid, ShiftsImagesAcrossPeriodicSides) {
  const CellGrid grid({0, 0, 0}, {4, 4, 4}, {true, false, false}, 1, 1000);
  const auto seen = Neighbours(grid, {0.5, 0.5, 0.5});
  EXPECT_TRUE(seen.contains({grid.Index({3, 0, 0}), {-4, 0, 0}}));
  EXPECT_EQ(seen.size(), 12u);
}

TEST(CellGrid, AOneCellBoxSeesItsOwnImages) {
  const CellGrid grid({0, 0, 0}, {1, 1, 1}, {true, true, true}, 1, 1000);
  EXPECT_EQ(grid.size(), 1u);
  EXPECT_EQ(Neighbours(grid, {0.5, 0.5, 0.5}).size(), 27u);
}

TEST(CellGrid, StopsWhenTheVisitSaysSo) {
  const CellGrid grid({0, 0, 0}, {5, 5, 5}, {true, true, true}, 1, 1000);
  int visits = 0;
  EXPECT_TRUE(
      grid.AnyNeighbour({2, 2, 2}, [&](std::size_t, const Vector3&) { return ++visits == 4; }));
  EXPECT_EQ(visits, 4);
}

TEST(CellGrid, WrapsAndClamps) {
  const CellGrid grid({-1, 0, 0}, {1, 2, 2}, {true, true, false}, 1, 1000);
  EXPECT_EQ(grid.Wrap({1.5, -0.5, 7}), (Vector3{-0.5, 1.5, 7}));
  EXPECT_EQ(grid.CellOf({-5, 0.5, 9}), (CellGrid::Cell{0, 0, 1}));
}

TEST(CellGrid, LimitsItsSize) {
  const CellGrid grid({0, 0, 0}, {1000, 1000, 1000}, {true, true, true}, 1, 5000);
  EXPECT_LE(grid.size(), 5000u);
  EXPECT_GT(grid.size(), 1000u);
}

}  // namespace
}  // namespace powdercal
