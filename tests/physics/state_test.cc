// A simulation that is written down and read again in its place goes on as one that was not.

#include <gmock/gmock.h>

#include "backends/embedded/simulation.h"
#include "core/errors.h"
#include "tests/physics/detours.h"

namespace powdercal::physics {
namespace {

using embedded::Settings;
using embedded::Simulation;

Settings Best(int threads = 1) { return {.isa = embedded::BestIsa(), .threads = threads}; }

Packing Placed(const Program& program) {
  return PlaceParticles(program.particles, program.domain, std::get<Insert>(program.stages.front()),
                        {});
}

void ExpectSameState(const Simulation& a, const Simulation& b) {
  EXPECT_EQ(a.steps(), b.steps());
  Trace one;
  one.moments = {{.packing = a.CurrentPacking(), .contacts = a.CurrentContacts()}};
  Trace other;
  other.moments = {{.packing = b.CurrentPacking(), .contacts = b.CurrentContacts()}};
  ExpectIdentical(one, other);
  const auto expect_same = [](const embedded::Body& p, const embedded::Body& q) {
    EXPECT_EQ(p.force, q.force) << p.name;
    EXPECT_EQ(p.displacement, q.displacement) << p.name;
    EXPECT_EQ(p.velocity, q.velocity) << p.name;
  };
  for (std::size_t n = 0; n < a.planes().size(); ++n) expect_same(a.planes()[n], b.planes()[n]);
  for (std::size_t n = 0; n < a.groups().size(); ++n) expect_same(a.groups()[n], b.groups()[n]);
  for (std::size_t n = 0; n < a.meshes().size(); ++n) expect_same(a.meshes()[n], b.meshes()[n]);
  EXPECT_EQ(a.Cell().stress, b.Cell().stress);
  EXPECT_EQ(a.SaveState(), b.SaveState()) << "down to the order of the lists";
}

// `simulation` after `steps` more, and one that was made anew from its state half way, with other
// settings.
void ExpectSameAfterReading(const Program& program, Simulation& simulation, std::int64_t steps,
                            const Settings& settings) {
  if (steps > 1) {
    ASSERT_TRUE(simulation.Run(steps / 2, {}));
  }
  Simulation resumed(program, {}, settings);
  resumed.LoadState(simulation.SaveState());
  ExpectSameState(simulation, resumed);
  ASSERT_TRUE(simulation.Run(steps - steps / 2, {}));
  ASSERT_TRUE(resumed.Run(steps - steps / 2, {}));
  ExpectSameState(simulation, resumed);
}

// A bed on a mesh that a servo loads, with springs in its contacts.
TEST(SavedState, BedGoesOnToTheLastBit) {
  const Program program = Bed(1e-3);
  Simulation simulation(program, Placed(program), Best());
  ASSERT_TRUE(simulation.Run(800, {}));
  simulation.planes()[2].wall.position = simulation.MakeSurvey().top;
  simulation.planes()[2].servo = embedded::ServoControl{.target = 900 * program.domain.BaseArea(),
                                                        .speed = 0.05,
                                                        .integral_time = 1e-3,
                                                        .max_velocity = 0.5};
  simulation.meshes()[0].Start({.body = "floor", .velocity = {0.05, 0, 0}});
  simulation.BodiesMoved();
  ExpectSameAfterReading(program, simulation, 1001, Best(2));
  EXPECT_NE(simulation.meshes()[0].force[2], 0);
  EXPECT_FALSE(simulation.CurrentContacts().empty()) << "there is something to remember";
  EXPECT_GT(simulation.counters().rebuilds, 2) << "lists were rebuilt on the way";
}

TEST(SavedState, GluedGroupGoesOnToTheLastBit) {
  const Program program = LoadedBed();
  Simulation simulation(program, *program.particles.packing, Best());
  simulation.groups()[0].velocity = {0, 0.05, 0};
  ASSERT_TRUE(simulation.Run(2500, {}));
  ExpectSameAfterReading(program, simulation, 800, Best());
  EXPECT_NE(simulation.groups()[0].force[2], 0);
}

TEST(SavedState, ShearedCellGoesOnToTheLastBit) {
  const Program program = Cell(ContactLaw::Rolling::epsd2, 1e-3);
  const Deform& deform = std::get<Deform>(program.stages[1]);
  Simulation simulation(program, Placed(program), Best(2));
  simulation.SetCellDrive(embedded::CellDrive{
      .edges = deform.edges, .shear_rate = deform.shear_rate, .pace = 200, .gain = deform.gain});
  ASSERT_TRUE(simulation.Run(900, {}));
  ExpectSameAfterReading(program, simulation, 700, Best(3));
}

TEST(SavedState, ReadsIntoPortableKernels) {
  const Program program = Cell(ContactLaw::Rolling::cdt, 1e-3);
  Simulation simulation(program, Placed(program), Best());
  ASSERT_TRUE(simulation.Run(300, {}));
  ExpectSameAfterReading(program, simulation, 400, {.isa = Isa::portable, .threads = 1});
}

// Before the first step nothing has been looked at.
TEST(SavedState, MayBeTakenAtTheStart) {
  const Program program = Cell(ContactLaw::Rolling::epsd2, 1e-3);
  Simulation simulation(program, Placed(program), Best());
  ExpectSameAfterReading(program, simulation, 1, Best());
}

TEST(SavedState, RefusesWhatItCannotGoOnFrom) {
  const Program program = Cell(ContactLaw::Rolling::epsd2, 1e-3);
  Simulation simulation(program, Placed(program), Best());
  ASSERT_TRUE(simulation.Run(10, {}));
  const std::string state = simulation.SaveState();
  Program other = program;
  other.time_step *= 2;
  const auto message = [&](const Program& owner, const std::string& bytes) -> std::string {
    Simulation reader(owner, {}, Best());
    try {
      reader.LoadState(bytes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(program, state), "");
  EXPECT_THAT(message(other, state), testing::HasSubstr("another program"));
  EXPECT_THAT(message(program, state.substr(0, state.size() - 1)), testing::HasSubstr("damaged"));
  EXPECT_THAT(message(program, state.substr(0, 100)), testing::HasSubstr("damaged"));
  std::string flipped = state;
  flipped[flipped.size() / 2] ^= 1;
  EXPECT_THAT(message(program, flipped), testing::HasSubstr("damaged"));
  EXPECT_THAT(message(program, ""), testing::HasSubstr("not the state"));
}

}  // namespace
}  // namespace powdercal::physics
