#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/table.h"
#include "optimizers/optimizer.h"
#include "studies/results.h"
#include "studies/study.h"
#include "surrogates/validation.h"

namespace powdercal {

/// Known evaluations that surrogates may be fitted to.
struct KnownEvaluations {
  struct Response {
    std::string name;
    std::string unit;
    Eigen::MatrixXd points;  ///< n × d, in the unit box of `space`
    Eigen::VectorXd values;  ///< n
  };
  SearchSpace space;  ///< the inputs; units and bounds as in the source
  std::vector<Response> responses;
  std::vector<std::string> notes;  ///< on what was left out, for people
};

/// From a table, in the units of its header. Responses are the columns `responses`, or the last
/// one. Inputs are all other columns without a dot in their name, on the box that the rows fill; a
/// column with a dot is a response, and a constant one tells nothing: both are left out.
/// `logarithmic`: inputs on a log scale. Throws InputError for an unknown name, for fewer than
/// three rows, where no input is left, and for values ≤ 0 on a log scale.
KnownEvaluations EvaluationsOf(const Table& table, const std::vector<std::string>& responses,
                               const std::vector<std::string>& logarithmic);

/// From the ledger of a study, SI: every evaluation with the mean over its replicates, on the box
/// and the scales that were searched; `logarithmic` as above. Responses are `responses`, named
/// "experiment.response", or all that the experiments measured; those with fewer than three values
/// are left out. Throws InputError for an unknown name and where nothing is left.
KnownEvaluations EvaluationsOf(const Study& study, const StudyResults& results,
                               const std::vector<std::string>& responses,
                               const std::vector<std::string>& logarithmic);

struct ComparisonOptions {
  int folds = 5;           ///< ≥ 2; at most as many as there are points are made
  int repeats = 5;         ///< ≥ 1, partitions of k-fold and of hold-out
  double hold_out = 0.25;  ///< share held out, in (0, 1)
  std::uint64_t seed = 1;  ///< of the partitions
};

/// What one surrogate makes of one response.
struct SurrogateAccuracy {
  std::string name;
  std::string description;  ///< of the fit to all points; "" where it failed
  std::string why_not;      ///< why there are no figures; "" otherwise
  CrossPrediction leave_one_out;
  RepeatedAccuracy k_fold;
  RepeatedAccuracy hold_out;
};
struct ResponseComparison {
  std::string response;
  std::string unit;
  Eigen::VectorXd values;
  int folds = 0;                              ///< as made
  std::vector<SurrogateAccuracy> surrogates;  ///< all, sorted by name
  std::string best;                           ///< BestOf() them; "" where none has an R²
};
/// `before_each`: called with every surrogate's name before it is fitted.
ResponseComparison CompareOn(const KnownEvaluations::Response& response,
                             const ComparisonOptions& options,
                             const std::function<void(const std::string&)>& before_each = {});

}  // namespace powdercal
