#pragma once

#include <string>

namespace powdercal::cli {

/// Progress on stderr: lines, and on a terminal a status below them that is redrawn in place.
class StatusLine {
 public:
  StatusLine();
  ~StatusLine();  ///< takes the status away
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  bool terminal() const { return terminal_; }
  /// A line that stays.
  void Line(const std::string& text);
  /// Replaces the status; nothing where stderr is no terminal.
  void Show(const std::string& text);

 private:
  void Clear();

  bool terminal_;
  bool shown_ = false;
};

/// "[#####...............] 5/20".
std::string ProgressBar(int done, int all);

}  // namespace powdercal::cli
