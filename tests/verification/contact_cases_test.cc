#include "verification/contact_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "backends/registry.h"
#include "core/errors.h"

namespace powdercal::verification {
namespace {

double Distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Largest overlap of the moment; negative: the gap.
double Overlap(const Program& program, const Packing& packing) {
  if (packing.size() == 2) {
    return packing[0].radius + packing[1].radius -
           Distance(packing[0].position, packing[1].position);
  }
  return packing[0].radius - (packing[0].position[2] - program.walls[0].position);
}

Trace Simulate(const Program& program) { return MakeBackend("embedded")->Run(program, {}); }

TEST(ContactCases, BeginApartTouchAndPartAgainWithoutCohesion) {
  for (const char* law : {"hertz_mindlin_history", "linear", "hertz_mindlin_history_epsd2"}) {
    for (const ContactCase& contact : ContactCases(ShippedLaw(law))) {
      const Trace trace = Simulate(contact.program);
      ASSERT_TRUE(trace.outcome.ok()) << contact.name << ": " << trace.outcome.message;
      EXPECT_GE(trace.moments.size(), 50U) << contact.name;
      EXPECT_LE(trace.moments.size(), 250U) << contact.name;
      EXPECT_LT(Overlap(contact.program, *contact.program.particles.packing), 0) << contact.name;
      double most = 0;
      std::size_t touching = 0;
      for (const Moment& moment : trace.moments) {
        const double overlap = Overlap(contact.program, moment.packing);
        most = std::max(most, overlap);
        if (overlap > 0) ++touching;
      }
      const double radius = contact.program.particles.packing->front().radius;
      EXPECT_GT(most, 5e-4 * radius) << law << ", " << contact.name;
      EXPECT_LT(most, 0.1 * radius) << law << ", " << contact.name;
      EXPECT_GT(touching, 5U) << law << ", " << contact.name;
      EXPECT_LT(Overlap(contact.program, trace.moments.back().packing), 0)
          << law << ", " << contact.name;
    }
  }
}

// What a case is said to look at has an effect on it, and what it is said not to look at has none.
TEST(ContactCases, SlipAndTwistAsTheySay) {
  const auto end = [](const Program& program) { return Simulate(program).moments.back().packing; };
  for (const ContactCase& contact : ContactCases(ShippedLaw("hertz_mindlin_history_epsd2"))) {
    const Packing reference = end(contact.program);
    const auto change = [&](const Program& program) {
      const Packing other = end(program);
      double largest = 0;
      for (std::size_t i = 0; i < other.size(); ++i) {
        const double r = other[i].radius;
        largest = std::max({largest, Distance(other[i].velocity, reference[i].velocity),
                            r * Distance(other[i].spin, reference[i].spin)});
      }
      return largest / 0.02;
    };
    Program program = contact.program;
    program.law.shear_update = ContactLaw::ShearUpdate::incremental;
    // The others that slip slide all the time: what they look at is Coulomb's limit.
    for (const char* sticks : {"oblique", "all at once", "wall, oblique"}) {
      if (contact.name != sticks) continue;
      EXPECT_TRUE(contact.slips);
      EXPECT_GT(change(program), 1e-5) << contact.name;
    }
    if (!contact.slips) {
      EXPECT_LT(change(program), 1e-13) << contact.name;
    }
    program = contact.program;
    program.law.torsion = false;
    if (contact.twists) {
      EXPECT_GT(change(program), 1e-5) << contact.name;
    } else if (!contact.slips) {
      EXPECT_LT(change(program), 1e-13) << contact.name;
    }
  }
}

// The updates of the tangential spring are one law where its stiffness is constant.
TEST(ContactCases, LinearSpringsHaveOneUpdate) {
  for (const ContactCase& contact : ContactCases(ShippedLaw("linear"))) {
    Program program = contact.program;
    program.law.shear_update = ContactLaw::ShearUpdate::incremental;
    const Packing a = Simulate(contact.program).moments.back().packing;
    const Packing b = Simulate(program).moments.back().packing;
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_LT(Distance(a[i].velocity, b[i].velocity), 1e-9 * 0.02) << contact.name;
    }
  }
}

TEST(ContactCases, LevelsAndTolerances) {
  const auto levels = [](const std::string& law) {
    std::set<std::string> found;
    for (const ContactCase& contact : ContactCases(ShippedLaw(law))) found.insert(contact.level);
    return found;
  };
  EXPECT_EQ(levels("linear"), (std::set<std::string>{"L0", "T"}));
  EXPECT_EQ(levels("hertz_mindlin_history"), (std::set<std::string>{"L1", "L2", "T", "W"}));
  EXPECT_EQ(levels("hertz_mindlin_history_dmt"), (std::set<std::string>{"L3", "T", "X"}));
  EXPECT_EQ(levels("hertz_mindlin_history_epsd2"),
            (std::set<std::string>{"L1", "L4", "T", "W", "X"}));
  EXPECT_EQ(levels("paper"), (std::set<std::string>{"P"}));

  ContactLaw law;
  EXPECT_EQ(ContactTolerance({.level = "L0", .slips = true}, law), 1e-7);
  EXPECT_EQ(ContactTolerance({.level = "L1"}, law), 1e-12);
  EXPECT_EQ(ContactTolerance({.level = "L2", .slips = true}, law), 1e-9);
  law.shear_update = ContactLaw::ShearUpdate::incremental;
  EXPECT_EQ(ContactTolerance({.level = "L2", .slips = true}, law), 1e-6);
  EXPECT_EQ(ContactTolerance({.level = "L2"}, law), 1e-9);
  EXPECT_EQ(ContactTolerance({.level = "W", .wall = true}, law), 1e-8);
  EXPECT_EQ(ContactTolerance({.level = "T", .slips = true}, law), 1e-3);
  EXPECT_EQ(ContactTolerance({.level = "L3"}, law), 1e-9);
  EXPECT_EQ(ContactTolerance({.level = "L4"}, law), 1e-9);
}

TEST(Laws, AreSortedAndUnknownOnesAreErrors) {
  const auto names = LawNames();
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  for (const std::string& name : names) EXPECT_EQ(ShippedLaw(name).name, name);
  try {
    ShippedLaw("hertz_mindlin_histori");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().suggestion, "hertz_mindlin_history");
  }
}

}  // namespace
}  // namespace powdercal::verification
