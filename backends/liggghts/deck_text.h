#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

namespace powdercal::liggghts {

/// The commands of a deck, in the making.
class DeckText {
 public:
  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    text_ += fmt::format(format, std::forward<Args>(args)...);
    text_ += '\n';
  }

  /// Sets a variable to what an expression is now: later runs or dumps do not change it.
  void Freeze(const std::string& name, const std::string& expression) {
    Add("variable formula equal {}\nvariable {} equal ${{formula}}", expression, name);
  }

  void Append(const std::string& text) { text_ += text; }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace powdercal::liggghts
