#pragma once

#include <nlohmann/json.hpp>

namespace powdercal {

/// What `powdercal compare --json` prints, without what is measured, and how it was asked for.
inline nlohmann::json Reproducible(nlohmann::json document) {
  document.erase("command");
  for (auto& optimizer : document["optimizers"]) optimizer.erase("optimizer_s_per_evaluation");
  for (auto& contest : document["contests"]) contest.erase("optimizer_s");
  return document;
}

}  // namespace powdercal
