#pragma once

#include <optional>
#include <span>

#include "scaling/conditions.h"

namespace powdercal {

// What each group of groups.h is made of, for groups.cc, which evaluates, and verdicts.cc, which
// judges.

using GroupEvaluation = std::optional<double> (*)(const Conditions&);

struct GroupDefinition {
  const char* symbol;
  const char* meaning;
  GroupEvaluation evaluate;
  // Remarks on a simulation whose group is too large or too small; {factor} ≥ 1, {simulation} and
  // {experiment} are filled in.
  const char* above;
  const char* below;
  // What must be small on both sides for a difference not to matter; null: it always matters.
  GroupEvaluation harmless_measure = nullptr;
  double harmless_limit = 0;
  const char* harmless = "";
};

/// A group of the simulation alone, which must stay small.
struct NumericalGroup {
  const char* symbol;
  const char* meaning;
  GroupEvaluation evaluate;
  double limit;            // ok up to here
  double violation_limit;  // violated beyond
  const char* above;       // {simulation} is filled in
  const char* source;
};

/// In the order of groups.h.
std::span<const GroupDefinition> GroupDefinitions();
std::span<const NumericalGroup> NumericalGroups();

}  // namespace powdercal
