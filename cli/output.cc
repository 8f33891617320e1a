#include "cli/output.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>

namespace powdercal::cli {
namespace {

std::atomic<int> output_error = 0;  // errno of the first failure

void Note(bool succeeded) {
  if (!succeeded && output_error == 0) output_error = errno;
}

}  // namespace

void OpenStandardStreams() {
  int descriptor = open("/dev/null", O_RDWR);
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) descriptor = open("/dev/null", O_RDWR);
  if (descriptor >= 0) close(descriptor);
}

void WriteOutput(std::string_view text) {
  Note(std::fwrite(text.data(), 1, text.size(), stdout) == text.size());
}

void WriteError(std::string_view text) {
  Note(std::fflush(stdout) == 0);  // on a terminal, both in the order of writing
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

bool OutputIsTerminal() { return isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr; }

bool FlushOutput() {
  Note(std::fflush(stdout) == 0);
  errno = output_error;
  return output_error == 0 || output_error == EPIPE;
}

}  // namespace powdercal::cli
