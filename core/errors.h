#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace powdercal {

/// A place in a text file. Lines and columns count from 1; 0 means unknown.
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;

  /// "study.yaml:12:5", "study.yaml" when the line is unknown, "" when the file is.
  std::string ToString() const;
};

/// A mistake of the user's: in a study file, a data file, on the command line, in the environment.
/// The message says where (file, line, column, key path), what value was found and, where one is
/// close, the valid name that was probably meant. Mistakes of the programmer's are assertions.
class InputError : public std::runtime_error {
 public:
  struct Details {
    SourceLocation location;
    std::string key;         ///< key path, e.g. "experiments[0].consolidation.stress"
    std::string value;       ///< the offending value as it was written; "" when there is none
    std::string suggestion;  ///< nearest valid name; "" when none is near
  };

  explicit InputError(const std::string& problem) : InputError(problem, Details{}) {}
  InputError(const std::string& problem, Details details);

  const std::string& problem() const { return problem_; }
  const Details& details() const { return details_; }

 private:
  std::string problem_;
  Details details_;
};

/// The candidate nearest to `name` by Damerau–Levenshtein distance without regard to case, or "" if
/// none is near enough to be a likely slip (distance above a third of the longer name, at least 1).
std::string NearestName(std::string_view name, std::span<const std::string> candidates);

/// The InputError for a name that is not one of `valid`: "unknown backend 'ligghts' (valid:
/// embedded, liggghts, table); did you mean 'liggghts'?".
InputError UnknownName(std::string_view what, std::string_view name,
                       std::span<const std::string> valid, InputError::Details details = {});

/// "a, b, c".
std::string JoinNames(std::span<const std::string> names);

}  // namespace powdercal
