#pragma once

#include <string>

namespace powdercal {

/// How much a group matters in a test.
struct Relevance {
  bool matters = true;   ///< false: it is shown, and never warned of
  double tolerance = 0;  ///< factor, either way, up to which it is `ok`
  std::string source;    ///< where that comes from, or why it does not matter
};

/// By the experiment's name and the group's symbol. Where nothing is known of the pair, the group
/// matters, and the tolerance is kMatchFactor, a convention.
Relevance RelevanceOf(const std::string& test, const std::string& symbol);

}  // namespace powdercal
