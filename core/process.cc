#include "core/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/process_guard.h"
#include "core/text.h"

namespace powdercal {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
using internal::GuardReport;

// How long a killed group may take to vanish (a process that waits for a dead disk cannot die)
// before the caller goes on without it.
constexpr Seconds kBurialLimit{10};

class Descriptor {
 public:
  Descriptor() = default;
  // Takes ownership; throws std::system_error for the −1 of a failed call. Never 0, 1 or 2, even
  // where the caller has closed those: the program's own are put there.
  Descriptor(int value, const char* what) : value_(value) {
    if (value_ >= 0 && value_ <= STDERR_FILENO) {
      value_ = fcntl(value, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
      close(value);
    }
    if (value_ < 0) throw std::system_error(errno, std::system_category(), what);
  }
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  ~Descriptor() { Close(); }

  void Close() {
    if (value_ >= 0) close(std::exchange(value_, -1));
  }
  int get() const { return value_; }  // −1, which poll() ignores, once closed

 private:
  int value_ = -1;
};

struct Pipe {
  Pipe() {
    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) {
      throw std::system_error(errno, std::system_category(), "cannot create a pipe");
    }
    const int write_end = ends[1];
    read = Descriptor(ends[0], "cannot create a pipe");
    write = Descriptor(write_end, "cannot create a pipe");
  }
  Descriptor read;
  Descriptor write;
};

// The beginning and the end of a long text.
class BoundedText {
 public:
  explicit BoundedText(std::size_t limit)
      : head_limit_(limit - limit / 2), tail_limit_(limit / 2) {}

  void Append(std::string_view text) {
    const std::size_t to_head = std::min(text.size(), head_limit_ - head_.size());
    head_ += text.substr(0, to_head);
    tail_ += text.substr(to_head);
    // Cut seldom: each cut moves the whole tail.
    if (tail_.size() > 2 * tail_limit_ + 65536) CutTail();
  }

  bool truncated() const { return left_out_ > 0 || tail_.size() > tail_limit_; }

  std::string Finish() {
    if (tail_.size() > tail_limit_) CutTail();
    if (left_out_ == 0) return ValidUtf8(head_ + tail_);
    return fmt::format("{}\n[... {} bytes left out ...]\n{}", ValidUtf8(head_), left_out_,
                       ValidUtf8(tail_));
  }

 private:
  void CutTail() {
    const std::size_t excess = tail_.size() - tail_limit_;
    tail_.erase(0, excess);
    left_out_ += excess;
  }

  std::size_t head_limit_;
  std::size_t tail_limit_;
  std::string head_;
  std::string tail_;
  std::size_t left_out_ = 0;
};

std::vector<char*> Pointers(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> ChildEnvironment(const ProcessOptions& options) {
  const std::map<std::string, std::string> added(options.environment.begin(),
                                                 options.environment.end());
  std::vector<std::string> variables;
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    const std::string_view text(*variable);
    if (!added.contains(std::string(text.substr(0, text.find('='))))) variables.emplace_back(text);
  }
  for (const auto& [name, value] : added) variables.push_back(name + "=" + value);
  return variables;
}

// One program, from the fork to the last words of its guard.
class Run {
 public:
  Run(const ProcessOptions& options, const std::filesystem::path& program)
      : options_(options), program_(program), output_text_(options.output_limit) {}

  ProcessResult Execute(std::stop_token stop) {
    Start();
    {
      const std::stop_callback wake(stop, [this] { eventfd_write(stop_event_.get(), 1); });
      Supervise();
    }
    // A process that left the group may hold the pipe open, so there may never be an end of file.
    int waiting = 0;
    if (output_.read.get() >= 0) ioctl(output_.read.get(), FIONREAD, &waiting);
    while (waiting > 0) {
      const std::size_t count = ReadOutput();
      if (count == 0) break;
      waiting -= static_cast<int>(count);
    }
    if (guard_gone_) {
      while (waitpid(guard_, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    result_.output_truncated = output_text_.truncated();
    const std::string captured = output_text_.Finish();
    if (result_.end != ProcessResult::End::not_started) result_.output = captured;
    result_.wall_seconds = Elapsed().count();
    return std::move(result_);
  }

 private:
  using End = ProcessResult::End;

  void Start() {
    const Descriptor input(open("/dev/null", O_RDONLY | O_CLOEXEC), "cannot open /dev/null");
    const std::vector<std::string> environment = ChildEnvironment(options_);
    const std::vector<char*> argument_pointers = Pointers(options_.arguments);
    const std::vector<char*> environment_pointers = Pointers(environment);
    const bool elsewhere = !options_.working_directory.empty();
    guard_ = internal::StartGuard({
        .program = program_.c_str(),
        .arguments = argument_pointers.data(),
        .environment = environment_pointers.data(),
        .directory = elsewhere ? options_.working_directory.c_str() : nullptr,
        .input = input.get(),
        .output = output_.write.get(),
        .report = report_.write.get(),
        .lifeline = lifeline_.read.get(),
    });
    if (guard_ < 0) throw std::system_error(errno, std::system_category(), "cannot fork");
    output_.write.Close();
    report_.write.Close();
    lifeline_.read.Close();
  }

  void Supervise() {
    while (!guard_gone_) {
      pollfd watched[] = {{report_.read.get(), POLLIN, 0},
                          {output_.read.get(), POLLIN, 0},
                          {decided_ ? -1 : stop_event_.get(), POLLIN, 0}};
      const int ready = poll(watched, std::size(watched), PollTimeout());
      if (ready > 0 && watched[1].revents != 0) ReadOutput();
      if (ready > 0 && watched[0].revents != 0) ReadReport();
      if (ready > 0 && watched[2].revents != 0) Kill(End::cancelled);
      if (Clock::now() < deadline_) continue;
      if (decided_) return;
      Kill(End::time_limit);
    }
  }

  int PollTimeout() const {
    if (deadline_ == Clock::time_point::max()) return -1;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline_ - Clock::now());
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 3600 * 1000));
  }

  void ReadReport() {
    GuardReport report{};
    const ssize_t count = read(report_.read.get(), &report, sizeof report);
    if (count < 0) return;
    if (count == 0) {
      guard_gone_ = true;
      if (!decided_) GuardWasKilled();
    } else if (report.kind == GuardReport::Kind::started) {
      group_ = report.value;
    } else if (!decided_) {
      Decide(report);
    }
  }

  void Decide(const GuardReport& report) {
    const char* reason = strerrordesc_np(report.value);
    switch (report.kind) {
      case GuardReport::Kind::not_forked:
        result_.output = fmt::format("cannot fork: {}", reason);
        break;
      case GuardReport::Kind::no_directory:
        result_.output = fmt::format("cannot enter the directory '{}': {}",
                                     options_.working_directory.string(), reason);
        break;
      case GuardReport::Kind::not_executed:
        result_.output = fmt::format("cannot execute '{}': {}", program_.string(), reason);
        break;
      case GuardReport::Kind::exited:
        result_.end = End::exited;
        result_.exit_status = report.value;
        break;
      default:
        result_.end = End::signalled;
        result_.signal = report.value;
    }
    SetDecided();
  }

  void Kill(End end) {
    if (decided_) return;
    result_.end = end;
    lifeline_.write.Close();
    SetDecided();
  }

  // By somebody else. The program died with it (PR_SET_PDEATHSIG), its own children did not.
  void GuardWasKilled() {
    result_.end = End::signalled;
    result_.signal = SIGKILL;
    if (group_ > 0) kill(-group_, SIGKILL);
  }

  void SetDecided() {
    decided_ = true;
    deadline_ = Clock::now() + std::chrono::ceil<Clock::duration>(kBurialLimit);
  }

  // Blocks when the pipe is empty. Returns the number of bytes read: 0 at the end of the file.
  std::size_t ReadOutput() {
    char buffer[1 << 14];
    const ssize_t count = read(output_.read.get(), buffer, sizeof buffer);
    if (count > 0) output_text_.Append({buffer, static_cast<std::size_t>(count)});
    if (count == 0) output_.read.Close();
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  Seconds Elapsed() const { return Clock::now() - start_; }

  static Clock::time_point Deadline(Clock::time_point start, const ProcessOptions& options) {
    constexpr Seconds kForever{1e9};
    if (!options.time_limit || !(*options.time_limit < kForever)) return Clock::time_point::max();
    return start + std::chrono::ceil<Clock::duration>(std::max(*options.time_limit, Seconds(0)));
  }

  const ProcessOptions& options_;
  const std::filesystem::path& program_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point deadline_ = Deadline(start_, options_);  // of the program, then of its burial
  Pipe output_;
  Pipe report_;
  Pipe lifeline_;
  Descriptor stop_event_{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "cannot create an event"};
  pid_t guard_ = -1;
  pid_t group_ = -1;
  bool decided_ = false;  // how the run ended
  bool guard_gone_ = false;
  BoundedText output_text_;
  ProcessResult result_;
};

bool IsExecutableFile(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

ProcessResult NotStarted(const std::string& why) {
  ProcessResult result;
  result.output = why;
  return result;
}

}  // namespace

std::string ProcessResult::Describe() const {
  switch (end) {
    case End::exited:
      return fmt::format("exited with status {}", exit_status);
    case End::signalled: {
      const char* name = sigdescr_np(signal);
      return fmt::format("killed by signal {} ({})", signal, name != nullptr ? name : "unknown");
    }
    case End::time_limit:
      return fmt::format("exceeded its time limit (killed after {:.4g} s)", wall_seconds);
    case End::cancelled:
      return "was cancelled";
    case End::not_started:
      return "could not be started: " + output;
  }
  return "";
}

std::filesystem::path FindProgram(const std::string& name) {
  if (name.empty()) return {};
  if (name.find('/') != std::string::npos) {
    return IsExecutableFile(name) ? std::filesystem::absolute(name) : std::filesystem::path();
  }
  const char* variable = std::getenv("PATH");
  std::string_view rest = variable != nullptr ? variable : "/bin:/usr/bin";  // as execvp() does
  while (true) {
    const std::size_t colon = rest.find(':');
    const std::filesystem::path folder(rest.substr(0, colon));  // empty: the current directory
    if (IsExecutableFile(folder / name)) return std::filesystem::absolute(folder / name);
    if (colon == std::string_view::npos) return {};
    rest.remove_prefix(colon + 1);
  }
}

ProcessResult RunProcess(const ProcessOptions& options, std::stop_token stop) {
  if (options.arguments.empty()) return NotStarted("no program was named");
  const std::string& name = options.arguments.front();
  const std::filesystem::path program = FindProgram(name);
  if (program.empty()) {
    return NotStarted(name.find('/') != std::string::npos
                          ? fmt::format("'{}' is not an executable file", name)
                          : fmt::format("there is no program '{}' on PATH", name));
  }
  if (stop.stop_requested()) {
    ProcessResult result;
    result.end = ProcessResult::End::cancelled;
    return result;
  }
  try {
    return Run(options, program).Execute(stop);
  } catch (const std::system_error& error) {
    return NotStarted(fmt::format("cannot start '{}': {}", name, error.what()));
  }
}

}  // namespace powdercal
