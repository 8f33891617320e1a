#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "studies/study.h"

namespace powdercal::benchmarks {

/// One experiment of a shipped study, at one point, over several particle seeds.
struct Case {
  std::string name;
  std::string experiment;
  std::vector<double> parameters;  ///< SI, in the order of the study's search space
  Overrides overrides;             ///< of the study
};

/// What the seeds of a case gave.
struct Sample {
  std::map<std::string, std::vector<double>> responses;    ///< SI, of the runs that ended well
  std::map<std::string, std::vector<double>> diagnostics;  ///< and steps, simulator_seconds
  std::map<std::string, int> outcomes;                     ///< by reason code
  std::vector<std::string> failures;                       ///< messages
};

struct CampaignOptions {
  std::string study = "hastelloy_x_joint_soft";
  int first_seed = 1;
  int seeds = 5;
  int parallel = 2;
  double time_limit = 900;  ///< [s] of one run
};

/// The study of that name in studies/library/. Throws InputError.
Study LoadShipped(const std::string& name, const Overrides& overrides = {});
/// Index into Study::experiments. Throws std::invalid_argument if it is not there.
std::size_t IndexOf(const Study& study, const std::string& experiment);
/// Path of the experiment's section, for overrides: "experiments[1].shear".
std::string SectionOf(const Study& study, const std::string& experiment);

/// Runs all seeds of all cases, several at a time; says on standard error how far it is.
std::vector<Sample> RunCampaign(std::span<const Case> cases, const CampaignOptions& options);

/// Difference of two means, Mean(a) − Mean(b), with its 95 % interval (Welch 1947); without an
/// interval where nothing scatters. Requires two values on each side.
struct Difference {
  double value = 0;
  double half_width = 0;
};
Difference Welch(const std::vector<double>& a, const std::vector<double>& b);

/// {"mean": …, "sd": …, "n": …}; null without values.
nlohmann::json Statistics(const std::vector<double>& values);
/// {"responses": {name: statistics}, "diagnostics": {…}, "outcomes": {…}, "failures": […]}.
nlohmann::json ToJson(const Sample& sample);

}  // namespace powdercal::benchmarks
