#include "core/errors.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace powdercal {
namespace {

const std::vector<std::string> kBackends = {"embedded", "liggghts", "table", "yade"};

TEST(SourceLocation, LeavesOutWhatIsUnknown) {
  EXPECT_EQ((SourceLocation{"study.yaml", 12, 5}).ToString(), "study.yaml:12:5");
  EXPECT_EQ((SourceLocation{"study.yaml", 12, 0}).ToString(), "study.yaml:12");
  EXPECT_EQ((SourceLocation{"study.yaml", 0, 5}).ToString(), "study.yaml");
  EXPECT_EQ((SourceLocation{"", 12, 5}).ToString(), "");
}

TEST(InputError, MessageHoldsAllDetails) {
  const InputError error("must be above 0 Pa", {.location = {"study.yaml", 12, 5},
                                                .key = "shear.preshear",
                                                .value = "-9 kPa",
                                                .suggestion = "9 kPa"});
  EXPECT_STREQ(error.what(),
               "study.yaml:12:5: shear.preshear: must be above 0 Pa (found '-9 kPa'); "
               "did you mean '9 kPa'?");
  EXPECT_EQ(error.problem(), "must be above 0 Pa");
  EXPECT_EQ(error.details().key, "shear.preshear");
  EXPECT_EQ(error.details().location.line, 12);
}

TEST(InputError, PlainProblemStaysAsItIs) {
  EXPECT_STREQ(InputError("no backend is available").what(), "no backend is available");
}

TEST(InputError, ValueIsNotRepeated) {
  EXPECT_STREQ(InputError("'7 apples' is not a number", {.value = "7 apples"}).what(),
               "'7 apples' is not a number");
}

TEST(InputError, ValueIsGivenThoughTheProblemHappensToHoldItsDigits) {
  EXPECT_STREQ(InputError("must lie in [0, 1)", {.value = "1"}).what(),
               "must lie in [0, 1) (found '1')");
}

TEST(NearestName, FindsLikelySlips) {
  EXPECT_EQ(NearestName("ligghts", kBackends), "liggghts");    // one letter missing
  EXPECT_EQ(NearestName("liggghtss", kBackends), "liggghts");  // one too many
  EXPECT_EQ(NearestName("ydae", kBackends), "yade");           // two swapped
  EXPECT_EQ(NearestName("tabel", kBackends), "table");
  EXPECT_EQ(NearestName("YADE", kBackends), "yade");
}

TEST(NearestName, TakesTheNearestOfSeveral) {
  const std::vector<std::string> names = {"stresses", "stress"};
  EXPECT_EQ(NearestName("stres", names), "stress");
}

TEST(NearestName, KeepsQuietWhenNothingIsNear) {
  EXPECT_EQ(NearestName("granoo", kBackends), "");
  EXPECT_EQ(NearestName("yade", {}), "");
}

TEST(UnknownName, NamesTheValidOnes) {
  const InputError error =
      UnknownName("backend", "ligghts", kBackends, {.location = {"s.yaml", 3}});
  EXPECT_STREQ(error.what(),
               "s.yaml:3: unknown backend 'ligghts' (valid: embedded, liggghts, table, yade); "
               "did you mean 'liggghts'?");
  EXPECT_EQ(error.details().suggestion, "liggghts");
  EXPECT_EQ(error.details().value, "ligghts");
}

TEST(JoinNames, SeparatesWithCommas) {
  EXPECT_EQ(JoinNames(kBackends), "embedded, liggghts, table, yade");
  EXPECT_EQ(JoinNames({}), "");
}

}  // namespace
}  // namespace powdercal
