#include "tests/physics/determinism.h"

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

}  // namespace
}  // namespace powdercal::physics
