#include "studies/executor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>

namespace powdercal {
namespace {

using namespace std::chrono_literals;

TEST(LocalExecutor, RunsEveryJobOnceAndSeveralAtATime) {
  LocalExecutor executor(3);
  std::atomic<int> running = 0;
  std::atomic<int> most = 0;
  for (int i = 0; i < 12; ++i) {
    executor.Submit(i, [&](std::stop_token) {
      const int now = ++running;
      int seen = most;
      while (seen < now && !most.compare_exchange_weak(seen, now)) {
      }
      // Until another one has been seen beside this one, or long enough for it to have come.
      for (int wait = 0; wait < 200 && most < 2; ++wait) std::this_thread::sleep_for(5ms);
      --running;
      return LedgerRun{};
    });
  }
  std::set<std::int64_t> tickets;
  while (tickets.size() < 12) {
    const auto finished = executor.Wait(10s);
    ASSERT_TRUE(finished);
    EXPECT_TRUE(tickets.insert(finished->ticket).second);
  }
  EXPECT_GE(most, 2);
  EXPECT_LE(most, 3);
}

TEST(LocalExecutor, CancelReachesTheJobs) {
  LocalExecutor executor(1);
  executor.Submit(0, [](std::stop_token stop) {
    while (!stop.stop_requested()) std::this_thread::sleep_for(1ms);
    return LedgerRun{.outcome = {Reason::cancelled, ""}};
  });
  EXPECT_FALSE(executor.Wait(20ms));
  executor.Cancel();
  const auto finished = executor.Wait(10s);
  ASSERT_TRUE(finished);
  EXPECT_EQ(finished->run.outcome.reason, Reason::cancelled);
}

TEST(LocalExecutor, DestructionCancelsWhatRuns) {
  std::atomic<bool> stopped = false;
  std::atomic<bool> started = false;
  {
    LocalExecutor executor(1);
    executor.Submit(0, [&](std::stop_token stop) {
      started = true;
      while (!stop.stop_requested()) std::this_thread::sleep_for(1ms);
      stopped = true;
      return LedgerRun{};
    });
    while (!started) std::this_thread::sleep_for(1ms);
  }
  EXPECT_TRUE(stopped);
}

}  // namespace
}  // namespace powdercal
