#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class Arguments : public ::testing::TestWithParam<Mistake> {};

TEST_P(Arguments, AreExplainedAndStartNothing) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(GetParam().arguments, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, StartsWith("powdercal: "));
  for (const std::string& piece : GetParam().message) EXPECT_THAT(result.error, HasSubstr(piece));
  EXPECT_EQ(result.output, "");
  EXPECT_THAT(Listing(folder.path()), IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(
    Cli, Arguments,
    ::testing::Values(
        Mistake{{}, {"no command is given", "check, compare, list, report, resume, run, scale, simulate"}},
        Mistake{{"rn", "quickstart"}, {"unknown command 'rn'", "did you mean 'run'?"}},
        Mistake{{"run"}, {"study is required"}}, Mistake{{"resume"}, {"folder is required"}},
        Mistake{{"run", "quickstart", "--evaluatons", "3"},
                {"unknown option '--evaluatons'", "did you mean '--evaluations'?"}},
        Mistake{{"run", "quickstart", "surplus"}, {"not expected: surplus"}},
        Mistake{{"run", "quickstrat"},
                {"quickstrat: no such study", "hastelloy_x_table3", "did you mean 'quickstart'?"}},
        Mistake{{"run", "/nowhere/s.yaml"}, {"/nowhere/s.yaml: no such study file"}},
        Mistake{{"run", "/tmp"}, {"/tmp: cannot read the file: Is a directory"}},
        Mistake{{"run", ""}, {"no such study file"}},
        Mistake{{"run", "quickstart", "--out", ""}, {"--out: a value is missing"}},
        Mistake{{"run", "quickstart", "--evaluations", ""}, {"--evaluations: a value is missing"}},
        Mistake{{"run", "quickstart", "--evaluations", "0"},
                {"command line: budget.evaluations: must lie in [1, ", "(found '0')"}},
        Mistake{{"run", "quickstart", "--evaluations", "many"},
                {"command line: budget.evaluations: expected an integer (found 'many')"}},
        Mistake{{"run", "quickstart", "--wall-time", "5"},
                {"command line: budget.wall_time: '5' has no unit; expected a time"}},
        Mistake{{"run", "quickstart", "--backend", "ligghts"},
                {"unknown backend 'ligghts'", "did you mean 'liggghts'?"}},
        Mistake{{"run", "quickstart", "--set", "seed"},
                {"command line: expected --set KEY=VALUE (found 'seed')"}},
        Mistake{{"run", "quickstart", "--set", "=1"}, {"expected --set KEY=VALUE (found '=1')"}},
        Mistake{{"run", "quickstart", "--set", "budget.evaluatons=3"},
                {"command line: budget.evaluatons: no such key", "(found '3')",
                 "did you mean 'budget.evaluations'?"}},
        Mistake{{"run", "quickstart", "--set", "material.density=8220"},
                {"command line: material.density: '8220' has no unit; expected a density"}},
        Mistake{{"run", "quickstart", "--set", "seed=1", "--set", "seed=2"},
                {"command line: seed: given twice"}},
        Mistake{{"run", "quickstart", "--set", "seed=1", "--seed", "2"},
                {"command line: seed: given twice"}},
        Mistake{{"run", "quickstart", "--set", "study=../escape"},
                {"study: the study's name cannot be", "--out", "(found '../escape')"}},
        Mistake{{"resume", "/nowhere"}, {"/nowhere: not a run folder"}},
        Mistake{{"resume", "/tmp"}, {"/tmp: not a run folder"}},
        Mistake{{"report", "/nowhere"}, {"/nowhere: not a run folder"}},
        Mistake{{"list", "backend"}, {"unknown kind 'backend'", "did you mean 'backends'?"}}));

TEST(ArgumentsHelp, EveryCommandExplainsItself) {
  const TemporaryFolder folder;
  const Streams help = PowdercalStreams({"--help"}, folder.path());
  EXPECT_EQ(help.exit_status, 0);
  EXPECT_EQ(help.error, "");
  for (const std::string command : {"check", "list", "report", "resume", "run", "simulate"}) {
    EXPECT_THAT(help.output, HasSubstr(command));
    const Streams own = PowdercalStreams({command, "--help"}, folder.path());
    EXPECT_EQ(own.exit_status, 0) << command;
    EXPECT_THAT(own.output, HasSubstr("--json")) << command;
  }
}

}  // namespace
}  // namespace powdercal
