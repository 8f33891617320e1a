#include "scaling/relevance.h"

#include "scaling/groups.h"

namespace powdercal {
namespace {

struct Entry {
  const char* test;
  const char* symbol;
  bool matters;
  double tolerance;
  const char* source;
};

// The tolerances are measured: docs/validation/sensitivity.md has the derivatives of the responses
// by ln k, in standard deviations between particle seeds at its middle point. At constant stiffness
// F_c ~ k^3 and W ~ k^5, so that a response that changes by s per unit of ln k changes by one
// standard deviation when F_c is off by a factor of exp(3/s), W by exp(5/s).
constexpr Entry kEntries[] = {
    {"consolidation", "F_c/(sigma d^2)", true, 1.5,
     "a factor of 1.5 moves the void ratio by one standard deviation between seeds "
     "(docs/validation/sensitivity.md: 7.3 per ln k)"},
    {"consolidation", "W/(m g d)", false, kMatchFactor,
     "a bed that is loaded slowly feels the pull-off force, not the work of separation"},
    {"consolidation", "F_w/F_c", false, kMatchFactor,
     "only the layers at floor and lid feel it, and the void ratio is taken away from them"},
    {"shear", "F_w/F_c", false, kMatchFactor, "the powder shears against itself, not along a wall"},
    {"shear", "F_c/(sigma d^2)", true, 1.2,
     "a factor of 1.2 moves the void ratio in steady state by one standard deviation between seeds "
     "(docs/validation/sensitivity.md: 14.4 per ln k)"},
    {"spreading", "Bo", true, 1.4,
     "a factor of 1.4 moves the share that is swept away by one standard deviation between seeds "
     "(docs/validation/sensitivity.md: 9.5 per ln k)"},
    {"spreading", "W/(m g d)", true, 1.7,
     "a factor of 1.7 moves the share that is swept away by one standard deviation between seeds, "
     "if that follows the work of separation (docs/validation/sensitivity.md: 9.5 per ln k)"},
};

}  // namespace

Relevance RelevanceOf(const std::string& test, const std::string& symbol) {
  for (const Entry& entry : kEntries) {
    if (test == entry.test && symbol == entry.symbol) {
      return {entry.matters, entry.tolerance, entry.source};
    }
  }
  return {true, kMatchFactor, "a convention: within a tenth"};
}

}  // namespace powdercal
