#include "core/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/errors.h"

namespace powdercal {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

InputError Failure(const std::filesystem::path& path, const char* what, int error) {
  return InputError(fmt::format("{}: {}", what, strerrordesc_np(error)),
                    {.location = {path.string()}});
}

}  // namespace

std::string ReadFile(const std::filesystem::path& path) {
  // Not std::ifstream, which opens directories, and whose `<< rdbuf()` fails for empty files.
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rbe"));
  if (!file) throw Failure(path, "cannot read the file", errno);
  std::string text;
  char buffer[1 << 14];
  while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, file.get())) {
    text.append(buffer, count);
  }
  if (std::ferror(file.get())) throw Failure(path, "cannot read the file", errno);
  return text;
}

void WriteFileAtomically(const std::filesystem::path& path, std::string_view text) {
  static std::atomic<int> counter = 0;  // several threads may write the same file
  const std::string temporary = fmt::format("{}.{}.{}.tmp", path.string(), getpid(), ++counter);
  const int file = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) throw Failure(path, "cannot write the file", errno);
  bool written = true;
  while (written && !text.empty()) {
    const ssize_t count = write(file, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    written = count > 0;
    if (written) text.remove_prefix(static_cast<std::size_t>(count));
  }
  written = written && fsync(file) == 0;
  int reason = errno;
  close(file);
  if (written) {
    if (rename(temporary.c_str(), path.c_str()) == 0) return;
    reason = errno;
  }
  unlink(temporary.c_str());
  throw Failure(path, "cannot write the file", reason);
}

}  // namespace powdercal
