#include <gmock/gmock.h>
#include <sys/wait.h>

#include <functional>
#include <map>
#include <thread>

#include "studies/ledger.h"
#include "tests/support/program.h"
#include "tests/support/simulators.h"

// SIGKILL and SIGTERM in the middle of a study, on each simulator.

namespace powdercal {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

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

// The parameter is the backend's name.
class Kill : public ::testing::TestWithParam<const char*> {
 protected:
  std::vector<std::string> Arguments() const {
    return {"run",           "quickstart",
            "--backend",     GetParam(),
            "--out",         path_.string(),
            "--parallel",    "2",
            "--set",         "backend.replicates=1",
            "--set",         "backend.confirm_replicates=2",
            "--evaluations", "5"};
  }

  // Whether it is at work: then the ledger is whole, and simulations run.
  bool WaitForStart() const {
    return WaitFor(
        [&] {
          if (GetParam() == std::string("liggghts")) return !SimulatorsIn(path_).empty();
          try {
            return !Ledger(path_ / "ledger.sqlite", Ledger::Mode::read_only).Events().empty();
          } catch (const std::exception&) {  // still in the making
            return false;
          }
        },
        60s);
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "x";
};

TEST_P(Kill, NothingFinishedIsRepeatedAndNoSimulatorIsLeft) {
  const pid_t child = Start(Arguments());
  ASSERT_TRUE(WaitForStart());
  ASSERT_TRUE(WaitFor([&] { return RunsByKey(path_).size() >= 2; }, 300s));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status)) << "it had come to its end before";
  EXPECT_TRUE(WaitFor([&] { return SimulatorsIn(path_).empty(); }, 10s)) << "orphans";
  const auto before = RunsByKey(path_);
  ASSERT_GE(before.size(), 2u);

  const ProcessResult again = Powdercal(Arguments(), folder_.path());
  ASSERT_EQ(again.exit_status, 0) << again.output;
  const auto after = RunsByKey(path_);
  for (const auto& [key, id] : before) {
    ASSERT_TRUE(after.contains(key)) << "lost";
    EXPECT_EQ(after.at(key), id) << "replaced";
  }
  const nlohmann::json results = ReadJson(path_ / "results.json");
  EXPECT_EQ(results["evaluations"]["total"], 5);
  EXPECT_EQ(after.size(), 5u + 1u) << "one run a point, and one more to confirm the best";
}

TEST_P(Kill, TerminateIsGracefulPromptAndResumable) {
  const pid_t child = Start(Arguments());
  ASSERT_TRUE(WaitForStart());
  const auto sent = std::chrono::steady_clock::now();
  kill(child, SIGTERM);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_LT(std::chrono::steady_clock::now() - sent, 10s);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_TRUE(SimulatorsIn(path_).empty());
  EXPECT_TRUE(fs::exists(path_ / "report.html")) << "what is known so far is reported";
  for (const LedgerRun& run : Ledger(path_ / "ledger.sqlite", Ledger::Mode::read_only).Runs()) {
    EXPECT_NE(run.outcome.reason, Reason::cancelled) << "a cancelled run is no result";
  }
}

// At standard fidelity a simulation takes some seconds, which a stop must not wait for.
TEST_P(Kill, SimulationsInFlightStopAtOnce) {
  std::vector<std::string> arguments = Arguments();
  arguments.insert(arguments.end(), {"--fidelity", "standard"});
  const pid_t child = Start(arguments);
  ASSERT_TRUE(WaitForStart());
  std::this_thread::sleep_for(300ms);
  const auto sent = std::chrono::steady_clock::now();
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_LT(std::chrono::steady_clock::now() - sent, 2s);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
}

INSTANTIATE_TEST_SUITE_P(Backends, Kill, ::testing::Values("embedded", "liggghts"),
                         [](const auto& parameter) { return std::string(parameter.param); });

}  // namespace
}  // namespace powdercal
