#pragma once

#include <sys/types.h>

namespace powdercal::internal {

/// What the guard and the program-to-be tell the caller through the report pipe. Smaller than
/// PIPE_BUF, hence always written in one piece.
struct GuardReport {
  enum class Kind : int {
    started,       ///< value: the program's process, which is also its group
    not_forked,    ///< value: errno
    no_directory,  ///< value: errno
    not_executed,  ///< value: errno
    exited,        ///< value: exit status
    signalled,     ///< value: signal
  };
  Kind kind;
  int value;
};

/// All that is needed after the fork, prepared before it: a child of a process with several threads
/// may call nothing but async-signal-safe functions, so it can neither allocate nor look things up.
/// Descriptors are close-on-exec and above 2.
struct GuardPlan {
  const char* program;  ///< absolute path
  char* const* arguments;
  char* const* environment;
  const char* directory;  ///< null: the caller's
  int input;              ///< the program's standard input
  int output;             ///< the program's standard output and error
  int report;             ///< write end
  int lifeline;           ///< read end; nothing is ever written, it only closes
};

/// Forks the guard of one program. The guard (in a process group of its own, all signals blocked)
/// forks the program into another group, and kills that group when the program ends or the lifeline
/// closes; once all of its members are dead the guard exits, which closes the report pipe.
/// Returns the guard's process, or −1 with errno.
pid_t StartGuard(const GuardPlan& plan);

}  // namespace powdercal::internal
