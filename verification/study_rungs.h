#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "studies/planner.h"
#include "verification/finding.h"
#include "verification/seed_rung.h"

namespace powdercal::verification {

/// Rung 3: the experiments of a study at one point, one case each. Margin of a response: the
/// standard deviation of its observation, since a difference that the laboratory could not see
/// changes no calibration; of one that was not observed 5 % of its mean, and it does not count.
/// `margins` replaces them, by "experiment.response", and makes the response count.
std::vector<SeedCase> ExperimentCases(const Planner& planner, const std::vector<double>& parameters,
                                      int seeds, const std::map<std::string, double>& margins);

/// Names that `margins` may have, with their SI units.
std::map<std::string, std::string> ExperimentQuantities(const Study& study);

/// Findings on experiments that cannot be planned, whatever the backend: a shear test without
/// tangential history.
std::vector<Finding> UnplannedExperiments(const Planner& planner,
                                          std::span<const Contender> contenders);

/// Rung 4: would each backend have accepted the parameters? From the findings of rung 3, for each
/// pair: z = (mean − observed)/√(sd² + s²/n) of each calibrated response, with s the scatter over n
/// seeds, and chi² = Σ z², to be at most the 1 − level quantile of the chi-squared distribution
/// with as many degrees of freedom as responses. `different`: the reference a accepts them, b does
/// not. Where a does not accept them either, there is nothing to confirm: `unsupported`.
std::vector<Finding> JudgeCalibration(const Study& study, std::span<const Finding> experiments,
                                      double level);

}  // namespace powdercal::verification
