#include "core/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

namespace powdercal {
namespace {

std::string Compose(const std::string& problem, const InputError::Details& details) {
  std::string text = details.location.ToString();
  if (!text.empty()) text += ": ";
  if (!details.key.empty()) text += details.key + ": ";
  text += problem;
  const std::string value = fmt::format("'{}'", details.value);
  if (!details.value.empty() && problem.find(value) == std::string::npos) {
    text += fmt::format(" (found {})", value);
  }
  if (!details.suggestion.empty()) text += fmt::format("; did you mean '{}'?", details.suggestion);
  return text;
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

// Optimal string alignment: insertions, deletions, substitutions and swaps of neighbours.
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t cost = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + cost});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string SourceLocation::ToString() const {
  if (file.empty() || line <= 0) return file;
  if (column <= 0) return fmt::format("{}:{}", file, line);
  return fmt::format("{}:{}:{}", file, line, column);
}

InputError::InputError(const std::string& problem, Details details)
    : std::runtime_error(Compose(problem, details)),
      problem_(problem),
      details_(std::move(details)) {}

std::string NearestName(std::string_view name, std::span<const std::string> candidates) {
  const std::string wanted = LowerCase(name);
  std::string best;
  std::size_t best_distance = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = EditDistance(wanted, LowerCase(candidate));
    const std::size_t limit =
        std::max<std::size_t>(1, std::max(wanted.size(), candidate.size()) / 3);
    if (distance <= limit && (best.empty() || distance < best_distance)) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string JoinNames(std::span<const std::string> names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

InputError UnknownName(std::string_view what, std::string_view name,
                       std::span<const std::string> valid, InputError::Details details) {
  details.value = std::string(name);
  details.suggestion = NearestName(name, valid);
  std::string problem = fmt::format("unknown {} '{}'", what, name);
  if (!valid.empty()) problem += fmt::format(" (valid: {})", JoinNames(valid));
  return InputError(problem, std::move(details));
}

}  // namespace powdercal
