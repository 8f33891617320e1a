#include "cli/status_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

#include "cli/output.h"

namespace powdercal::cli {
namespace {

// The status line is redrawn in place, which takes a single line of the terminal.
std::string FitTerminal(std::string text) {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return text;
  int columns = size.ws_col;  // the last one stays free: a full line wraps on some terminals
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool starts_character = (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80;
    if (starts_character && --columns == 0) text.resize(i);
  }
  return text;
}

}  // namespace

StatusLine::StatusLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

StatusLine::~StatusLine() { Clear(); }

void StatusLine::Line(const std::string& text) {
  Clear();
  Say("{}\n", text);
}

void StatusLine::Show(const std::string& text) {
  if (!terminal_) return;
  Say("\r\033[K{}", FitTerminal(text));
  shown_ = true;
}

void StatusLine::Clear() {
  if (!shown_) return;
  Say("\r\033[K");
  shown_ = false;
}

std::string ProgressBar(int done, int all) {
  constexpr int kWidth = 20;
  const int filled = all > 0 ? std::min(kWidth, kWidth * done / all) : 0;
  return fmt::format("[{}{}] {}/{}", std::string(static_cast<std::size_t>(filled), '#'),
                     std::string(static_cast<std::size_t>(kWidth - filled), '.'), done, all);
}

}  // namespace powdercal::cli
