#include <gmock/gmock.h>
#include <sys/wait.h>

#include <functional>
#include <map>
#include <thread>

#include "studies/ledger.h"
#include "tests/support/program.h"
#include "tests/support/simulators.h"

// SIGKILL in the middle of a study on the real LIGGGHTS.

namespace powdercal {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

const std::vector<std::string> kArguments = {
    "run", "quickstart", "--evaluations",        "5",     "--parallel",
    "2",   "--set",      "backend.replicates=1", "--set", "backend.confirm_replicates=2"};

std::map<std::string, std::int64_t> RunsByKey(const fs::path& folder) {
  std::map<std::string, std::int64_t> keys;
  for (const LedgerRun& run : Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only).Runs()) {
    EXPECT_TRUE(keys.emplace(run.key, run.id).second) << "run twice: " << run.key;
  }
  return keys;
}

bool WaitFor(const std::function<bool()>& condition, std::chrono::seconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(50ms);
  }
  return false;
}

// Starts the program without waiting for it.
pid_t Start(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), POWDERCAL_PROGRAM);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execv(argv[0], argv.data());
    _exit(127);
  }
  return child;
}

TEST(Kill, NothingFinishedIsRepeatedAndNoSimulatorIsLeft) {
  const TemporaryFolder folder;
  const fs::path path = folder / "x";
  std::vector<std::string> arguments = kArguments;
  arguments.insert(arguments.end(), {"--out", path.string()});

  const pid_t child = Start(arguments);
  // Not before a simulator works: the ledger may still be in the making.
  ASSERT_TRUE(WaitFor([&] { return !SimulatorsIn(path).empty(); }, 60s));
  ASSERT_TRUE(
      WaitFor([&] { return RunsByKey(path).size() >= 2 && !SimulatorsIn(path).empty(); }, 300s));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(WaitFor([&] { return SimulatorsIn(path).empty(); }, 10s)) << "orphans";
  const auto before = RunsByKey(path);
  ASSERT_GE(before.size(), 2u);

  const ProcessResult again = Powdercal(arguments, folder.path());
  ASSERT_EQ(again.exit_status, 0) << again.output;
  const auto after = RunsByKey(path);
  for (const auto& [key, id] : before) {
    ASSERT_TRUE(after.contains(key)) << "lost";
    EXPECT_EQ(after.at(key), id) << "replaced";
  }
  const nlohmann::json results = ReadJson(path / "results.json");
  EXPECT_EQ(results["evaluations"]["total"], 5);
  EXPECT_EQ(after.size(), 5u + 1u) << "one run a point, and one more to confirm the best";
}

TEST(Kill, TerminateIsGracefulAndResumable) {
  const TemporaryFolder folder;
  const fs::path path = folder / "x";
  std::vector<std::string> arguments = kArguments;
  arguments.insert(arguments.end(), {"--out", path.string()});
  const pid_t child = Start(arguments);
  ASSERT_TRUE(WaitFor([&] { return !SimulatorsIn(path).empty(); }, 60s));
  kill(child, SIGTERM);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_TRUE(SimulatorsIn(path).empty());
  EXPECT_TRUE(fs::exists(path / "report.html")) << "what is known so far is reported";
  for (const LedgerRun& run : Ledger(path / "ledger.sqlite", Ledger::Mode::read_only).Runs()) {
    EXPECT_NE(run.outcome.reason, Reason::cancelled) << "a cancelled run is no result";
  }
}

}  // namespace
}  // namespace powdercal
