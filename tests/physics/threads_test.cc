#include "tests/physics/detours.h"

namespace powdercal::physics {
namespace {

// Slow where there are fewer cores than threads.
TEST(Determinism, BedDoesNotDependOnThreads) { ExpectTheSame(Bed(1.5e-3), Threads()); }

TEST(Determinism, CellDoesNotDependOnThreads) {
  ExpectTheSame(Cell(ContactLaw::Rolling::epsd2, 1.5e-3), Threads());
  ExpectTheSame(Cell(ContactLaw::Rolling::cdt, 1.5e-3), Threads());
}

TEST(Determinism, LongRunsOfInstructionSetsAgree) {
  ExpectTheSame(Bed(2e-3), OneThread());
  ExpectTheSame(Cell(ContactLaw::Rolling::epsd2, 5e-3), OneThread());
}

TEST(Determinism, DetoursLeaveNoTraceWhateverTheWay) {
  std::vector<Way> ways = OneThread();
  ways.push_back({embedded::BestIsa(), 2});
  for (const Way& way : ways) {
    SCOPED_TRACE(fmt::format("{}, {} threads",
                             embedded::IsaNames()[static_cast<std::size_t>(way.isa)], way.threads));
    ExpectSameAfterDetour(ShearedCell(), CellDetour(), way);
    ExpectSameAfterDetour(LoadedBed(), BedDetour(), way);
  }
  ExpectTheSame(WithDetour(ShearedCell(), CellDetour()), ways);
  ExpectTheSame(WithDetour(LoadedBed(), BedDetour()), ways);
}

}  // namespace
}  // namespace powdercal::physics
