#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/study.h"

namespace powdercal {

/// What another scaling mode would cost a study, and which groups it would break.
struct ModeCost {
  std::string mode;  ///< "rigid_limit, kappa 4000"
  bool own = false;  ///< the study's own, with its options
  std::string why_not;
  double young_modulus = 0;     ///< [Pa] of the simulation
  std::optional<double> kappa;  ///< the least of the experiments
  double steps = 0;             ///< of one run of each experiment; right within a factor of about 2
  double seconds = 0;  ///< of the same, on as many cores as a run keeps busy; 0: no simulation
  /// "consolidation: sigma/E"; cohesion left out where it is a free parameter, or stated for the
  /// modulus of the study's own mode.
  std::vector<std::string> violated;
};

/// The study's own mode first; then none, and with the study's own modulus sigma_over_e and exact;
/// then rigid_limit at several floors of kappa. Steps come from the very programs that would be
/// run: at constant I and equal conditions they go as the root of E, or kappa^0.75.
std::vector<ModeCost> CompareModes(const Study& study, const std::vector<std::size_t>& experiments);

}  // namespace powdercal
