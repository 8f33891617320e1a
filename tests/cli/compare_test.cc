#include <gmock/gmock.h>

#include "tests/cli/streams.h"
#include "tests/support/comparison_document.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<std::string> kCompare = {
    "compare", "hastelloy_x_table3", "--evaluations",   "8",     "--seeds",
    "3",       "--optimizers",       "bayesian,random", "--out", "x"};

TEST(Compare, TableStudyEndToEnd) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(With(kCompare, {"--json"}), folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  const json document = json::parse(result.output);
  EXPECT_EQ(document, ReadJson(folder / "x/comparison.json"));
  EXPECT_THAT(Listing(folder / "x"), ElementsAre("comparison.html", "comparison.json",
                                                 "ledger.sqlite", "lock", "study.yaml"));
  EXPECT_EQ(document.at("schema"), 1);
  EXPECT_EQ(document.at("source").at("kind"), "table");
  EXPECT_EQ(document.at("judged_by"), "truth");
  EXPECT_EQ(document.at("seeds"), json({1, 2, 3}));
  EXPECT_EQ(document.at("contests").size(), 6U);
  EXPECT_EQ(document.at("interrupted"), false);
  // Eight evaluations are enough for the one and not for the other (docs/optimizers.md).
  EXPECT_EQ(document.at("optimizers").at(0).at("label"), "bayesian");
  EXPECT_LT(document.at("optimizers").at(0).at("final").at("median"), 0.7 * 0.7);
  EXPECT_EQ(document.at("optimizers").at(0).at("mean_rank"), 1);
  for (const json& contest : document.at("contests")) {
    EXPECT_EQ(contest.at("judged").size(), 8U);
    EXPECT_EQ(contest.at("core_seconds"), 8);
  }
  EXPECT_THAT(ReadFile(folder / "x/comparison.html"),
              AllOf(HasSubstr("<!doctype html>"), HasSubstr("the table backend answered"),
                    HasSubstr("bayesian"), HasSubstr("vega")));
  EXPECT_THAT(result.error, HasSubstr("report: x/comparison.html"));
}

TEST(Compare, TextHasTableRecommendationAndLimits) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(kCompare, folder.path());
  ASSERT_EQ(result.exit_status, 0) << result.error;
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("mean rank"), HasSubstr("bayesian"), HasSubstr("random"),
                    HasSubstr("Friedman"), HasSubstr("note: No simulation was run")));
}

TEST(Compare, GoesOnWhereItStopped) {
  const TemporaryFolder folder;
  ASSERT_EQ(PowdercalStreams(kCompare, folder.path()).exit_status, 0);
  const json first = ReadJson(folder / "x/comparison.json");
  const Streams again = PowdercalStreams(kCompare, folder.path());
  EXPECT_THAT(again.error, HasSubstr("6 of 6 contests are known"));
  EXPECT_EQ(ReadJson(folder / "x/comparison.json"), first);
  // More seeds: only the new ones. The result is that of one command.
  std::vector<std::string> more = kCompare;
  more[5] = "4";
  EXPECT_THAT(PowdercalStreams(more, folder.path()).error, HasSubstr("6 of 8 contests are known"));
  more.back() = "y";
  ASSERT_EQ(PowdercalStreams(more, folder.path()).exit_status, 0);
  EXPECT_EQ(Reproducible(ReadJson(folder / "x/comparison.json")),
            Reproducible(ReadJson(folder / "y/comparison.json")));
}

// The interrupt comes at no particular moment; wherever it does, the same command comes to the same
// end.
TEST(Compare, InterruptedGoesOn) {
  const TemporaryFolder folder;
  std::vector<std::string> command = kCompare;
  command[5] = "30";
  const auto compare = [&](const std::string& out, const std::string& limit) {
    command.back() = out;
    std::vector<std::string> words = {"timeout", "--preserve-status", "--signal=INT", limit,
                                      POWDERCAL_PROGRAM};
    words.insert(words.end(), command.begin(), command.end());
    return RunProcess({.arguments = words,
                       .working_directory = folder.path(),
                       .time_limit = std::chrono::minutes(2)})
        .exit_status;
  };
  const int status = compare("x", "1");
  ASSERT_THAT(status, AnyOf(0, 3));
  if (status == 3 && std::filesystem::exists(folder / "x/comparison.json")) {
    const json part = ReadJson(folder / "x/comparison.json");
    EXPECT_EQ(part.at("interrupted"), true);
    EXPECT_LT(part.at("contests").size(), 60U);
  }
  ASSERT_EQ(compare("x", "100"), 0);
  ASSERT_EQ(compare("y", "100"), 0);
  EXPECT_EQ(Reproducible(ReadJson(folder / "x/comparison.json")),
            Reproducible(ReadJson(folder / "y/comparison.json")));
}

TEST(Compare, ADamagedRecordIsWrittenAnew) {
  const TemporaryFolder folder;
  ASSERT_EQ(PowdercalStreams(kCompare, folder.path()).exit_status, 0);
  for (const char* text : {"{\"contests\": [{}]}", "{", "[]"}) {
    WriteFileAtomically(folder / "x/comparison.json", text);
    const Streams result = PowdercalStreams(kCompare, folder.path());
    EXPECT_EQ(result.exit_status, 0);
    EXPECT_THAT(result.error, HasSubstr("is written anew"));
  }
}

TEST(Compare, RefusedOptimizersAreListed) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(
      {"compare", "hastelloy_x_table3", "--evaluations", "4", "--seeds", "1", "--optimizers",
       "random,corners_and_centre,grid:levels=100000", "--out", "x", "--json"},
      folder.path());
  EXPECT_EQ(result.exit_status, 2);  // an option that was given is a mistake, not a refusal
  EXPECT_THAT(result.error, HasSubstr("a grid of 100000 levels"));
}

TEST(Compare, MistakesStartNothing) {
  struct Mistake {
    std::vector<std::string> arguments;
    std::string message;
  };
  const TemporaryFolder folder;
  for (const Mistake& mistake :
       std::vector<Mistake>{{{"--optimizers", "bayesain"}, "did you mean 'bayesian'?"},
                            {{"--optimizers", "random,random"}, "given twice"},
                            {{"--optimizers", "random:speed=3"}, "speed"},
                            {{"--seeds", "0"}, "--seeds"},
                            {{"--core-seconds=-1"}, "--core-seconds"},
                            {{"--hold-out-seeds=-1"}, "--hold-out-seeds"},
                            {{"--real"}, "simulates nothing"},
                            {{"--emulate", "nowhere"}, "simulates nothing"},
                            {{"--design", "10"}, "simulates nothing"},
                            {{"--sedes", "3"}, "did you mean '--seeds'?"}}) {
    const Streams result =
        PowdercalStreams(With({"compare", "hastelloy_x_table3"}, mistake.arguments), folder.path());
    EXPECT_EQ(result.exit_status, 2) << mistake.message;
    EXPECT_THAT(result.error, HasSubstr(mistake.message));
    EXPECT_EQ(result.output, "");
  }
  for (const Mistake& mistake :
       std::vector<Mistake>{{{"--emulate", "nowhere"}, "not a run folder"},
                            {{"--real", "--emulate", "x"}, "exclude each other"},
                            {{"--design", "10", "--real"}, "leave out --real"},
                            {{"--design", "2"}, "--design"}}) {
    const Streams result =
        PowdercalStreams(With({"compare", "quickstart"}, mistake.arguments), folder.path());
    EXPECT_EQ(result.exit_status, 2) << mistake.message;
    EXPECT_THAT(result.error, HasSubstr(mistake.message));
  }
  EXPECT_THAT(Listing(folder.path()), IsEmpty());
}

TEST(Compare, ARunOfAnotherProblemIsRefused) {
  const TemporaryFolder folder;
  ASSERT_EQ(PowdercalStreams({"run", "hastelloy_x_table3", "--evaluations", "6", "--out", "run"},
                             folder.path())
                .exit_status,
            0);
  const Streams result =
      PowdercalStreams({"compare", "quickstart", "--emulate", "run", "--out", "x"}, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, AllOf(HasSubstr("run: --emulate"), HasSubstr("of another problem"),
                                  HasSubstr("backend")));
  EXPECT_THAT(Listing(folder.path()), ElementsAre("run"));
}

TEST(Compare, FolderOfAnotherStudyIsRefused) {
  const TemporaryFolder folder;
  ASSERT_EQ(PowdercalStreams(kCompare, folder.path()).exit_status, 0);
  const Streams other = PowdercalStreams(With(kCompare, {"--seed", "2"}), folder.path());
  EXPECT_EQ(other.exit_status, 2);
  EXPECT_THAT(other.error, HasSubstr("belongs to another study"));
}

}  // namespace
}  // namespace powdercal
