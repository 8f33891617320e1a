#include "core/process_guard.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>

// Below StartGuard() everything runs in a forked child: async-signal-safe calls only.

namespace powdercal::internal {
namespace {

// _Fork skips the handlers that libraries registered with pthread_atfork (OpenBLAS stops its worker
// threads in one), which matter only to children that go on without exec.
pid_t Fork() {
#ifdef __SANITIZE_THREAD__
  return fork();  // ThreadSanitizer takes its own locks in here
#else
  return _Fork();
#endif
}

void Report(int descriptor, GuardReport::Kind kind, int value) {
  const GuardReport report{kind, value};
  // Fails only when the caller is dead, and then nobody needs the report.
  [[maybe_unused]] const ssize_t written = write(descriptor, &report, sizeof report);
}

void CloseRange(int first, int last) {
  if (first > last) return;
  if (close_range(static_cast<unsigned>(first), static_cast<unsigned>(last), 0) == 0) return;
  // Kernels before 5.9 have no close_range.
  rlimit limit{};
  const int open_max = getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < (1U << 20)
                           ? static_cast<int>(limit.rlim_cur)
                           : 1 << 20;
  for (int descriptor = first; descriptor <= std::min(last, open_max); ++descriptor) {
    close(descriptor);
  }
}

// Above all the lifelines of concurrent runs: they must be open in the caller only.
void CloseAllBut(std::array<int, 4> kept) {
  std::sort(kept.begin(), kept.end());
  int next = 0;
  for (const int descriptor : kept) {
    CloseRange(next, descriptor - 1);
    next = descriptor + 1;
  }
  CloseRange(next, 0x7fffffff);
}

void IgnoreSignal(int) {}

void ResetSignalHandlers() {
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  for (int number = 1; number < NSIG; ++number) sigaction(number, &action, nullptr);
}

[[noreturn]] void RunProgram(const GuardPlan& plan, pid_t guard) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // should somebody kill the guard
  if (getppid() != guard) _exit(127);
  dup2(plan.input, STDIN_FILENO);
  dup2(plan.output, STDOUT_FILENO);
  dup2(plan.output, STDERR_FILENO);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (plan.directory != nullptr && chdir(plan.directory) != 0) {
    Report(plan.report, GuardReport::Kind::no_directory, errno);
    _exit(127);
  }
  execve(plan.program, plan.arguments, plan.environment);
  Report(plan.report, GuardReport::Kind::not_executed, errno);
  _exit(127);
}

// Looks at the guard's dead children: reports the program's end, if it has ended, and reaps others,
// orphans of the program's. The program is not reaped yet: while it is a zombie, no other process
// group can be given its number.
bool HasEnded(const GuardPlan& plan, pid_t program) {
  while (true) {
    siginfo_t info{};
    waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT);
    if (info.si_pid == 0) return false;
    if (info.si_pid == program) {
      Report(plan.report,
             info.si_code == CLD_EXITED ? GuardReport::Kind::exited : GuardReport::Kind::signalled,
             info.si_status);
      return true;
    }
    waitpid(info.si_pid, nullptr, 0);
  }
}

// Until the program has ended or the lifeline closes.
void WaitForEnd(const GuardPlan& plan, pid_t program) {
  sigset_t waiting;
  sigfillset(&waiting);
  sigdelset(&waiting, SIGCHLD);
  while (!HasEnded(plan, program)) {
    pollfd lifeline{.fd = plan.lifeline, .events = POLLIN, .revents = 0};
    // SIGCHLD is blocked but for the time inside ppoll, so that none is missed.
    if (ppoll(&lifeline, 1, nullptr, &waiting) > 0) return;
  }
}

// Members whose parent is dead are the guard's children by now, for it is their subreaper.
void KillGroup(pid_t group) {
  kill(-group, SIGKILL);
  while (waitpid(-group, nullptr, 0) > 0 || errno == EINTR) {
  }
}

[[noreturn]] void RunGuard(const GuardPlan& plan) {
  setpgid(0, 0);
  ResetSignalHandlers();
  struct sigaction action {};
  action.sa_handler =
      IgnoreSignal;  // SIG_DFL and SIG_IGN would not interrupt ppoll; exec resets it
  sigaction(SIGCHLD, &action, nullptr);
  CloseAllBut({plan.input, plan.output, plan.report, plan.lifeline});
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  prctl(PR_SET_NAME, "powdercal-guard");

  const pid_t guard = getpid();
  const pid_t program = Fork();
  if (program == 0) RunProgram(plan, guard);
  if (program < 0) {
    Report(plan.report, GuardReport::Kind::not_forked, errno);
    _exit(1);
  }
  setpgid(program, program);  // both sides do it: whoever comes first
  close(plan.input);
  close(plan.output);
  Report(plan.report, GuardReport::Kind::started, program);
  WaitForEnd(plan, program);
  KillGroup(program);
  _exit(0);
}

}  // namespace

pid_t StartGuard(const GuardPlan& plan) {
  // No handler of the caller's may run in the children.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t guard = Fork();
  if (guard == 0) RunGuard(plan);
  const int error = errno;
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = error;
  return guard;
}

}  // namespace powdercal::internal
