#include "tests/physics/determinism.h"

namespace powdercal::physics {
namespace {

TEST(Determinism, InstructionSetsAgreeToTheLastBit) {
  ExpectTheSame(Bed(5e-4), OneThread());
  ExpectTheSame(Cell(ContactLaw::Rolling::epsd2, 1e-3), OneThread());
  ExpectTheSame(Cell(ContactLaw::Rolling::cdt, 1e-3), OneThread());
}

}  // namespace
}  // namespace powdercal::physics
