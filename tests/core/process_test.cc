#include "core/process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "core/files.h"

namespace powdercal {
namespace {

using End = ProcessResult::End;
using testing::HasSubstr;
using testing::StartsWith;

ProcessOptions Shell(const std::string& script) { return {.arguments = {"sh", "-c", script}}; }

// Until the condition holds. The limit is there to fail rather than hang.
bool WaitUntil(const std::function<bool()>& condition) {
  for (int i = 0; i < 6000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

// A zombie counts as dead: who reaps it is the business of this machine's init.
bool Alive(pid_t process) {
  std::ifstream stream("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  if (!std::getline(stream, text)) return false;
  const char state = text.at(text.rfind(')') + 2);
  return state != 'Z' && state != 'X';
}

class ProcessTest : public testing::Test {
 protected:
  ProcessTest() { std::filesystem::create_directories(folder_); }
  ~ProcessTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  // The process that a script wrote with "echo $$ > NAME.new; mv NAME.new NAME".
  pid_t WaitForPid(const std::string& name) const {
    if (!WaitUntil([&] { return std::filesystem::exists(folder_ / name); })) return -1;
    return std::stoi(ReadFile(folder_ / name));
  }
  // Shell commands for the above; `what` is $$, $! or $PPID.
  std::string Tell(const std::string& what, const std::string& name) const {
    return "echo " + what + " > " + Path(name) + ".new; mv " + Path(name) + ".new " + Path(name) +
           "; ";
  }

  void MakeFile(const std::string& name, const std::string& text, mode_t mode) const {
    std::ofstream(Path(name)) << text;
    chmod(Path(name).c_str(), mode);
  }

  const std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                        ("powdercal_process_test." + std::to_string(getpid()));
};

TEST_F(ProcessTest, ExitStatus) {
  ProcessResult result = RunProcess(Shell("exit 0"));
  EXPECT_EQ(result.end, End::exited);
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_TRUE(result.succeeded());
  EXPECT_EQ(result.output, "");
  EXPECT_GT(result.wall_seconds, 0);

  result = RunProcess(Shell("exit 3"));
  EXPECT_EQ(result.end, End::exited);
  EXPECT_EQ(result.exit_status, 3);
  EXPECT_FALSE(result.succeeded());
  EXPECT_EQ(result.Describe(), "exited with status 3");
}

TEST_F(ProcessTest, Signal) {
  const ProcessResult result = RunProcess(Shell("kill -USR1 $$"));
  EXPECT_EQ(result.end, End::signalled);
  EXPECT_EQ(result.signal, SIGUSR1);
  EXPECT_FALSE(result.succeeded());
  EXPECT_EQ(result.Describe(), "killed by signal 10 (User defined signal 1)");
}

TEST_F(ProcessTest, OutputAndErrorsComeTogetherInOrder) {
  const ProcessResult result = RunProcess(Shell("echo one; echo two >&2; printf three"));
  EXPECT_EQ(result.output, "one\ntwo\nthree");
  EXPECT_FALSE(result.output_truncated);
}

TEST_F(ProcessTest, ArgumentsArePassedAsTheyAre) {
  const ProcessResult result = RunProcess({.arguments = {"printf", "<%s>", "a b", "", "$HOME;*"}});
  EXPECT_EQ(result.output, "<a b><><$HOME;*>");
}

TEST_F(ProcessTest, StandardInputIsEmpty) {
  EXPECT_EQ(RunProcess(Shell("cat; echo end; readlink /proc/self/fd/0")).output,
            "end\n/dev/null\n");
}

TEST_F(ProcessTest, WorkingDirectory) {
  ProcessOptions options = Shell("pwd -P; echo x > written");
  options.working_directory = folder_;
  EXPECT_EQ(RunProcess(options).output, std::filesystem::canonical(folder_).string() + "\n");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "written"));
}

TEST_F(ProcessTest, RelativeProgramsAreRelativeToTheCaller) {
  MakeFile("program", "#!/bin/sh\npwd -P\n", 0755);
  ProcessOptions options{.arguments = {std::filesystem::relative(folder_ / "program").string()}};
  options.working_directory = "/";
  EXPECT_EQ(RunProcess(options).output, "/\n");
}

TEST_F(ProcessTest, EnvironmentIsAddedToTheCallers) {
  setenv("POWDERCAL_TEST_KEPT", "kept", 1);
  setenv("POWDERCAL_TEST_CHANGED", "before", 1);
  ProcessOptions options{.arguments = {"env"}};
  options.environment = {{"POWDERCAL_TEST_CHANGED", "after"}, {"POWDERCAL_TEST_NEW", "a=b"}};
  const std::string output = RunProcess(options).output;
  unsetenv("POWDERCAL_TEST_KEPT");
  unsetenv("POWDERCAL_TEST_CHANGED");
  EXPECT_THAT(output, HasSubstr("POWDERCAL_TEST_KEPT=kept\n"));
  EXPECT_THAT(output, HasSubstr("POWDERCAL_TEST_CHANGED=after\n"));
  EXPECT_THAT(output, Not(HasSubstr("POWDERCAL_TEST_CHANGED=before\n")));
  EXPECT_THAT(output, HasSubstr("POWDERCAL_TEST_NEW=a=b\n"));
}

TEST_F(ProcessTest, LongOutputKeepsBothEnds) {
  ProcessOptions options = Shell("echo first; seq 1 200000; echo last");
  options.output_limit = 1000;
  const ProcessResult result = RunProcess(options);
  EXPECT_TRUE(result.succeeded());
  EXPECT_TRUE(result.output_truncated);
  EXPECT_THAT(result.output, StartsWith("first\n1\n2\n"));
  EXPECT_THAT(result.output, testing::EndsWith("199999\n200000\nlast\n"));
  // 1288895 bytes of numbers and 11 of words.
  EXPECT_THAT(result.output, HasSubstr("\n[... 1287906 bytes left out ...]\n"));
  EXPECT_LT(result.output.size(), 1100U);
}

TEST_F(ProcessTest, OutputOfExactlyTheLimitIsWhole) {
  ProcessOptions options = Shell("printf 12345; printf 6789");
  options.output_limit = 9;
  ProcessResult result = RunProcess(options);
  EXPECT_EQ(result.output, "123456789");
  EXPECT_FALSE(result.output_truncated);
  options.output_limit = 8;
  result = RunProcess(options);
  EXPECT_EQ(result.output, "1234\n[... 1 bytes left out ...]\n6789");
  EXPECT_TRUE(result.output_truncated);
}

TEST_F(ProcessTest, OutputIsValidUtf8) {
  EXPECT_EQ(RunProcess(Shell("printf 'a\\377z \\302\\265m'")).output, "a\xEF\xBF\xBDz \u00b5m");
}

TEST_F(ProcessTest, NotStarted) {
  ProcessResult result = RunProcess({.arguments = {"powdercal-no-such-program"}});
  EXPECT_EQ(result.end, End::not_started);
  EXPECT_FALSE(result.succeeded());
  EXPECT_EQ(result.Describe(),
            "could not be started: there is no program 'powdercal-no-such-program' on PATH");

  MakeFile("data", "text", 0644);
  result = RunProcess({.arguments = {Path("data")}});
  EXPECT_EQ(result.end, End::not_started);
  EXPECT_EQ(result.output, "'" + Path("data") + "' is not an executable file");

  MakeFile("script", "#!/no/such/interpreter\n", 0755);
  result = RunProcess({.arguments = {Path("script")}});
  EXPECT_EQ(result.end, End::not_started);
  EXPECT_EQ(result.output, "cannot execute '" + Path("script") + "': No such file or directory");

  ProcessOptions options = Shell("echo no");
  options.working_directory = folder_ / "absent";
  result = RunProcess(options);
  EXPECT_EQ(result.end, End::not_started);
  EXPECT_EQ(result.output,
            "cannot enter the directory '" + Path("absent") + "': No such file or directory");

  EXPECT_EQ(RunProcess({}).end, End::not_started);
}

TEST_F(ProcessTest, TimeLimit) {
  ProcessOptions options = Shell("echo begun; exec sleep 1000");
  options.time_limit = std::chrono::milliseconds(300);
  const ProcessResult result = RunProcess(options);
  EXPECT_EQ(result.end, End::time_limit);
  EXPECT_EQ(result.output, "begun\n");
  EXPECT_GE(result.wall_seconds, 0.3);
  EXPECT_THAT(result.Describe(), StartsWith("exceeded its time limit (killed after "));
}

TEST_F(ProcessTest, AFarTimeLimitDoesNotMatter) {
  for (const double limit : {1e4, 1e12, std::numeric_limits<double>::infinity()}) {
    ProcessOptions options = Shell("exit 0");
    options.time_limit = std::chrono::duration<double>(limit);
    EXPECT_TRUE(RunProcess(options).succeeded());
  }
}

TEST_F(ProcessTest, Cancel) {
  // Programs that mind no polite signal must die, too.
  const ProcessOptions options =
      Shell("trap '' TERM INT HUP; " + Tell("$$", "program") + "while :; do sleep 1; done");
  ProcessResult result;
  {
    const std::jthread runner([&](std::stop_token stop) { result = RunProcess(options, stop); });
    EXPECT_TRUE(Alive(WaitForPid("program")));
  }  // ~jthread requests the stop
  EXPECT_EQ(result.end, End::cancelled);
  EXPECT_EQ(result.Describe(), "was cancelled");
  EXPECT_FALSE(Alive(WaitForPid("program")));
}

TEST_F(ProcessTest, CancelledBeforeTheStart) {
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(RunProcess(Shell("echo > " + Path("ran")), source.get_token()).end, End::cancelled);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "ran"));
}

TEST_F(ProcessTest, AStopAfterTheEndDoesNotMatter) {
  std::stop_source source;
  const ProcessResult result = RunProcess(Shell("exit 0"), source.get_token());
  source.request_stop();
  EXPECT_TRUE(result.succeeded());
}

TEST_F(ProcessTest, TheGroupDiesWithTheProgram) {
  // The second is an orphan: its parent ends at once.
  const ProcessResult result =
      RunProcess(Shell("sleep 1000 & " + Tell("$!", "child") + "(sleep 1000 & " +
                       Tell("$!", "orphan") + "); exit 5"));
  EXPECT_EQ(result.end, End::exited);
  EXPECT_EQ(result.exit_status, 5);
  EXPECT_FALSE(Alive(WaitForPid("child")));
  EXPECT_FALSE(Alive(WaitForPid("orphan")));
}

TEST_F(ProcessTest, TheGroupDiesWhenCancelled) {
  const ProcessOptions options = Shell("sleep 1000 & " + Tell("$!", "child") + "(sleep 1000 & " +
                                       Tell("$!", "orphan") + "); wait");
  ProcessResult result;
  {
    const std::jthread runner([&](std::stop_token stop) { result = RunProcess(options, stop); });
    EXPECT_TRUE(Alive(WaitForPid("child")));
    EXPECT_TRUE(Alive(WaitForPid("orphan")));
  }  // ~jthread requests the stop
  EXPECT_EQ(result.end, End::cancelled);
  EXPECT_FALSE(Alive(WaitForPid("child")));
  EXPECT_FALSE(Alive(WaitForPid("orphan")));
}

TEST_F(ProcessTest, AProgramThatKillsItsOwnGroup) {
  const ProcessResult result = RunProcess(Shell("echo before; kill -KILL 0; sleep 1000"));
  EXPECT_EQ(result.end, End::signalled);
  EXPECT_EQ(result.signal, SIGKILL);
  EXPECT_EQ(result.output, "before\n");
}

TEST_F(ProcessTest, AProcessThatLeftTheGroupDoesNotHoldUpTheCaller) {
  const ProcessResult result =
      RunProcess(Shell("setsid sleep 1000 & " + Tell("$!", "escaped") +
                       // until it has its session
                       "while [ \"$(cut -d' ' -f6 /proc/$!/stat)\" != $! ]; "
                       "do sleep 0.01; done; echo done"));
  EXPECT_EQ(result.end, End::exited);
  EXPECT_EQ(result.output, "done\n");
  const pid_t escaped = WaitForPid("escaped");
  EXPECT_TRUE(Alive(escaped));
  kill(escaped, SIGKILL);
}

TEST_F(ProcessTest, TheGroupDiesWithTheCaller) {
  const pid_t caller = fork();
  ASSERT_GE(caller, 0);
  if (caller == 0) {
    RunProcess(Shell("sleep 1000 & " + Tell("$!", "child") + Tell("$PPID", "guard") +
                     Tell("$$", "program") + "wait"));
    _exit(0);
  }
  const std::vector<pid_t> processes = {WaitForPid("program"), WaitForPid("child"),
                                        WaitForPid("guard")};
  for (const pid_t process : processes) EXPECT_TRUE(Alive(process));
  kill(caller, SIGKILL);
  waitpid(caller, nullptr, 0);
  for (const pid_t process : processes) {
    EXPECT_TRUE(WaitUntil([&] { return !Alive(process); }));
  }
}

TEST_F(ProcessTest, TheGroupDiesWithTheGuard) {
  ProcessResult result;
  {
    const std::jthread runner([&] {
      result = RunProcess(Shell("sleep 1000 & " + Tell("$!", "child") + Tell("$PPID", "guard") +
                                Tell("$$", "program") + "wait"));
    });
    ASSERT_TRUE(Alive(WaitForPid("program")));
    kill(WaitForPid("guard"), SIGKILL);
  }
  EXPECT_EQ(result.end, End::signalled);
  EXPECT_EQ(result.signal, SIGKILL);
  for (const char* name : {"program", "child"}) {
    EXPECT_TRUE(WaitUntil([&] { return !Alive(WaitForPid(name)); })) << name;
  }
}

// "pkill -9 -f powdercal" hits caller and guard alike.
TEST_F(ProcessTest, TheProgramDiesWithCallerAndGuard) {
  const pid_t caller = fork();
  ASSERT_GE(caller, 0);
  if (caller == 0) {
    RunProcess(Shell(Tell("$PPID", "guard") + Tell("$$", "program") + "exec sleep 1000"));
    _exit(0);
  }
  const pid_t program = WaitForPid("program");
  EXPECT_TRUE(Alive(program));
  kill(caller, SIGSTOP);  // or it would kill the group itself when the guard dies
  int status = 0;
  waitpid(caller, &status, WUNTRACED);
  EXPECT_TRUE(WIFSTOPPED(status));
  kill(WaitForPid("guard"), SIGKILL);
  EXPECT_TRUE(WaitUntil([&] { return !Alive(program); }));
  kill(caller, SIGKILL);
  waitpid(caller, nullptr, 0);
}

// So that it can wait until the whole group is dead.
TEST_F(ProcessTest, OrphansOfTheProgramAreTheGuards) {
  const ProcessResult result =
      RunProcess(Shell("(sleep 1000 & " + Tell("$!", "orphan") +
                       "); echo $PPID; cut -d' ' -f4 /proc/$(cat " + Path("orphan") + ")/stat"));
  pid_t guard = 0;
  pid_t parent = 1;
  ASSERT_EQ(std::sscanf(result.output.c_str(), "%d %d", &guard, &parent), 2) << result.output;
  EXPECT_EQ(parent, guard);
}

TEST_F(ProcessTest, NeitherProgramNorGuardIsInTheCallersGroup) {
  const std::string output =
      RunProcess(Shell("echo $(cut -d' ' -f5 /proc/$$/stat) $(cut -d' ' -f5 /proc/$PPID/stat)"))
          .output;
  pid_t program = 0;
  pid_t guard = 0;
  ASSERT_EQ(std::sscanf(output.c_str(), "%d %d", &program, &guard), 2) << output;
  EXPECT_NE(program, getpgrp());
  EXPECT_NE(guard, getpgrp());
  EXPECT_NE(guard, program);
}

TEST_F(ProcessTest, SignalSettingsAreNotInherited) {
  sigset_t blocked;
  sigset_t before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  void (*const handler)(int) = std::signal(SIGUSR2, SIG_IGN);
  const ProcessResult terminated = RunProcess(Shell("kill -TERM $$; echo survived"));
  const ProcessResult used = RunProcess(Shell("kill -USR2 $$; echo survived"));
  std::signal(SIGUSR2, handler);
  sigset_t after;
  pthread_sigmask(SIG_SETMASK, &before, &after);
  EXPECT_EQ(terminated.signal, SIGTERM) << terminated.output;
  EXPECT_EQ(used.signal, SIGUSR2) << used.output;
  EXPECT_EQ(sigismember(&after, SIGTERM), 1);  // the caller's own mask is as it was
  EXPECT_EQ(sigismember(&after, SIGINT), 0);
}

TEST_F(ProcessTest, DescriptorsAreNeitherInheritedNorLeaked) {
  const auto count = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  };
  const int inheritable = open("/dev/null", O_RDONLY);  // NOLINT: no O_CLOEXEC, on purpose
  const auto before = count();
  EXPECT_EQ(RunProcess({.arguments = {"ls", "/proc/self/fd"}}).output, "0\n1\n2\n3\n");
  RunProcess({.arguments = {"powdercal-no-such-program"}});
  ProcessOptions options = Shell("sleep 1000");
  options.time_limit = std::chrono::seconds(0);
  RunProcess(options);
  EXPECT_EQ(count(), before);
  close(inheritable);
}

TEST_F(ProcessTest, NoZombiesAreLeft) {
  RunProcess(Shell("exit 0"));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST_F(ProcessTest, ACallerWithoutStandardDescriptors) {
  const pid_t caller = fork();
  ASSERT_GE(caller, 0);
  if (caller == 0) {
    for (int descriptor = 0; descriptor < 3; ++descriptor) close(descriptor);
    const ProcessResult result = RunProcess(Shell("cat; echo out; echo err >&2"));
    _exit(result.succeeded() && result.output == "out\nerr\n" ? 42 : 1);
  }
  int status = 0;
  waitpid(caller, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 42);
}

TEST_F(ProcessTest, ManyThreadsAtOnce) {
  constexpr int kThreads = 8;
  constexpr int kRuns = 10;
  std::vector<int> right(kThreads);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([t, &right] {
        for (int i = 0; i < kRuns; ++i) {
          const std::string text = std::to_string(t) + ":" + std::to_string(i);
          const ProcessResult result =
              RunProcess(Shell("echo " + text + "; exit " + std::to_string(i)));
          if (result.exit_status == i && result.output == text + "\n") ++right[t];
        }
      });
    }
  }
  for (const int count : right) EXPECT_EQ(count, kRuns);
}

// Each guard must hear of its own lifeline although the others were forked while it was open.
TEST_F(ProcessTest, ConcurrentRunsAreCancelledOneByOne) {
  constexpr int kRuns = 6;
  std::vector<ProcessResult> results(kRuns);
  std::vector<std::jthread> threads;
  for (int i = 0; i < kRuns; ++i) {
    threads.emplace_back([&, i](std::stop_token stop) {
      results[i] = RunProcess(Shell(Tell("$$", std::to_string(i)) + "exec sleep 1000"), stop);
    });
  }
  std::vector<pid_t> programs;
  for (int i = 0; i < kRuns; ++i) programs.push_back(WaitForPid(std::to_string(i)));
  for (int i = 0; i < kRuns; ++i) {
    threads[i].request_stop();
    threads[i].join();
    EXPECT_EQ(results[i].end, End::cancelled);
    EXPECT_FALSE(Alive(programs[i]));
    for (int other = i + 1; other < kRuns; ++other) EXPECT_TRUE(Alive(programs[other]));
  }
}

TEST_F(ProcessTest, FindProgram) {
  EXPECT_EQ(FindProgram("powdercal-no-such-program"), "");
  EXPECT_EQ(FindProgram(""), "");
  EXPECT_TRUE(FindProgram("sh").is_absolute());

  for (const char* name : {"a", "b", "c"}) std::filesystem::create_directory(folder_ / name);
  std::filesystem::create_directory(folder_ / "a" / "tool");  // not a file
  MakeFile("b/tool", "#!/bin/sh\n", 0644);                    // not executable
  MakeFile("c/tool", "#!/bin/sh\n", 0755);
  const std::string before = std::getenv("PATH");
  setenv("PATH", (Path("a") + ":" + Path("b") + ":" + Path("c")).c_str(), 1);
  EXPECT_EQ(FindProgram("tool"), folder_ / "c" / "tool");
  EXPECT_EQ(FindProgram("sh"), "");
  setenv("PATH", before.c_str(), 1);

  EXPECT_EQ(FindProgram(Path("c/tool")), folder_ / "c" / "tool");
  EXPECT_EQ(FindProgram(Path("b/tool")), "");
  EXPECT_EQ(FindProgram(Path("a/tool")), "");
}

}  // namespace
}  // namespace powdercal
