#include "studies/surrogate_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/errors.h"
#include "core/quantity.h"
#include "core/statistics.h"

namespace powdercal {
namespace {

constexpr std::size_t kFewestPoints = 3;

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool IsResponseName(const std::string& name) { return name.find('.') != std::string::npos; }

// The values in the unit of the header.
std::vector<double> AsWritten(const Table::Column& column) {
  std::vector<double> values = column.values;
  const double to_si = Unit::Parse(column.unit).to_si();
  for (double& value : values) value /= to_si;
  return values;
}

void MakeLogarithmic(const std::vector<std::string>& names, const std::string& file,
                     SearchSpace* space) {
  std::vector<std::string> valid;
  for (const Parameter& parameter : space->parameters) valid.push_back(parameter.name);
  for (const std::string& name : names) {
    const auto found = std::find(valid.begin(), valid.end(), name);
    if (found == valid.end()) {
      throw UnknownName("input", name, valid, {.location = {file}, .key = "--log"});
    }
    Parameter& parameter = space->parameters[static_cast<std::size_t>(found - valid.begin())];
    if (parameter.levels() > 0) {
      throw InputError("an integer or a category has no log scale",
                       {.location = {file}, .key = "--log", .value = name});
    }
    if (!(parameter.lower > 0)) {
      throw InputError(
          fmt::format("a log scale needs values above 0; the lowest is {:g}", parameter.lower),
          {.location = {file}, .key = "--log", .value = name});
    }
    parameter.logarithmic = true;
  }
}

std::vector<std::string> ResponseColumns(const Table& table,
                                         const std::vector<std::string>& asked) {
  if (asked.empty()) return {table.columns().back().name};
  for (const std::string& name : asked) {
    if (!table.Has(name)) {
      throw UnknownName("column", name, table.column_names(),
                        {.location = {table.file()}, .key = "--response"});
    }
  }
  return asked;
}

// The inputs' columns, in order; adds their parameters and notes to `known`.
std::vector<std::vector<double>> InputColumns(const Table& table,
                                              const std::vector<std::string>& responses,
                                              KnownEvaluations* known) {
  std::vector<std::vector<double>> inputs;
  for (const Table::Column& column : table.columns()) {
    if (Contains(responses, column.name)) continue;
    if (IsResponseName(column.name)) {
      known->notes.push_back(fmt::format("column '{}' is a response, and left out", column.name));
      continue;
    }
    std::vector<double> values = AsWritten(column);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    if (*low == *high) {
      known->notes.push_back(
          fmt::format("column '{}' is {:g} in every row, and left out", column.name, *low));
      continue;
    }
    known->space.parameters.push_back({.name = column.name,
                                       .symbol = column.name,
                                       .unit = column.unit,
                                       .lower = *low,
                                       .upper = *high});
    inputs.push_back(std::move(values));
  }
  return inputs;
}

// Unit of each response that the study's experiments can measure, by "experiment.response".
std::map<std::string, std::string> UnitsOf(const Study& study) {
  std::map<std::string, std::string> units;
  for (const StudyExperiment& experiment : study.experiments) {
    for (const ResponseDescription& response : experiment.experiment->responses()) {
      units[experiment.name() + "." + response.name] = response.unit;
    }
  }
  return units;
}

// Mean of each response over the evaluation's replicates.
std::map<std::string, double> MeansOf(const EvaluationResult& evaluation) {
  std::map<std::string, std::vector<double>> values;
  for (const RunResult& run : evaluation.runs) {
    for (const auto& [response, value] : run.responses) {
      if (std::isfinite(value)) values[run.experiment + "." + response].push_back(value);
    }
  }
  std::map<std::string, double> means;
  for (const auto& [response, several] : values) means[response] = Mean(several);
  return means;
}

Eigen::VectorXd PointOf(const SearchSpace& space, const EvaluationResult& evaluation) {
  Eigen::VectorXd values(space.dimension());
  for (int d = 0; d < space.dimension(); ++d) {
    values[d] = evaluation.parameters.at(space.parameters[static_cast<std::size_t>(d)].name);
  }
  return space.ToUnit(values);
}

KnownEvaluations::Response Gather(const std::string& name, const std::string& unit,
                                  const std::vector<Eigen::VectorXd>& points,
                                  const std::vector<double>& values) {
  KnownEvaluations::Response response{.name = name, .unit = unit};
  const auto n = static_cast<Eigen::Index>(values.size());
  response.points.resize(n, points.empty() ? 0 : points.front().size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    response.points.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  }
  response.values = Eigen::Map<const Eigen::VectorXd>(values.data(), n);
  return response;
}

SurrogateAccuracy Assess(const std::string& name, const KnownEvaluations::Response& response,
                         const ComparisonOptions& options, int folds) {
  SurrogateAccuracy accuracy{.name = name};
  const SurrogateMaker make = MakerOf(name);
  const Eigen::MatrixXd& points = response.points;
  const Eigen::VectorXd& values = response.values;
  try {
    const std::unique_ptr<Surrogate> surrogate = make();
    surrogate->Fit(points, values, {});
    accuracy.leave_one_out = LeaveOneOut(make, points, values);
    accuracy.k_fold = KFold(make, points, values, folds, options.repeats, options.seed);
    accuracy.hold_out =
        HoldOut(make, points, values, options.hold_out, options.repeats, options.seed);
    accuracy.description = surrogate->Describe();
    if (std::isnan(accuracy.leave_one_out.r2)) accuracy.why_not = "all values are equal";
  } catch (const std::runtime_error& error) {
    accuracy.why_not = error.what();
  }
  return accuracy;
}

}  // namespace

KnownEvaluations EvaluationsOf(const Table& table, const std::vector<std::string>& responses,
                               const std::vector<std::string>& logarithmic) {
  if (table.row_count() < kFewestPoints) {
    throw InputError(fmt::format("the table has {} rows; a comparison needs at least {}",
                                 table.row_count(), kFewestPoints),
                     {.location = {table.file()}});
  }
  KnownEvaluations known;
  const std::vector<std::string> names = ResponseColumns(table, responses);
  const std::vector<std::vector<double>> inputs = InputColumns(table, names, &known);
  if (inputs.empty()) {
    throw InputError("no column is left that varies and is no response",
                     {.location = {table.file()}});
  }
  MakeLogarithmic(logarithmic, table.file(), &known.space);
  std::vector<Eigen::VectorXd> points;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    Eigen::VectorXd values(known.space.dimension());
    for (std::size_t d = 0; d < inputs.size(); ++d) {
      values[static_cast<Eigen::Index>(d)] = inputs[d][row];
    }
    points.push_back(known.space.ToUnit(values));
  }
  for (const std::string& name : names) {
    const auto column = std::find_if(table.columns().begin(), table.columns().end(),
                                     [&](const Table::Column& one) { return one.name == name; });
    known.responses.push_back(Gather(name, column->unit, points, AsWritten(*column)));
  }
  return known;
}

KnownEvaluations EvaluationsOf(const Study& study, const StudyResults& results,
                               const std::vector<std::string>& responses,
                               const std::vector<std::string>& logarithmic) {
  KnownEvaluations known;
  known.space.parameters = results.parameters;
  MakeLogarithmic(logarithmic, study.file, &known.space);
  const std::map<std::string, std::string> units = UnitsOf(study);
  std::vector<std::string> names;
  for (const auto& [name, unit] : units) names.push_back(name);
  for (const std::string& name : responses) {
    if (!units.contains(name)) {
      throw UnknownName("response", name, names, {.location = {study.file}, .key = "--response"});
    }
  }
  for (const std::string& name : responses.empty() ? names : responses) {
    std::vector<Eigen::VectorXd> points;
    std::vector<double> values;
    for (const EvaluationResult& evaluation : results.history) {
      const std::map<std::string, double> means = MeansOf(evaluation);
      const auto found = means.find(name);
      if (found == means.end()) continue;
      points.push_back(PointOf(known.space, evaluation));
      values.push_back(found->second);
    }
    if (values.size() >= kFewestPoints) {
      known.responses.push_back(Gather(name, units.at(name), points, values));
    } else if (!values.empty() || !responses.empty()) {
      known.notes.push_back(
          fmt::format("{} has {} values, too few, and is left out", name, values.size()));
    }
  }
  if (known.responses.empty()) {
    throw InputError(fmt::format("no response has {} values yet; a comparison needs at least that",
                                 kFewestPoints),
                     {.location = {study.file}});
  }
  return known;
}

ResponseComparison CompareOn(const KnownEvaluations::Response& response,
                             const ComparisonOptions& options,
                             const std::function<void(const std::string&)>& before_each) {
  ResponseComparison comparison{
      .response = response.name,
      .unit = response.unit,
      .values = response.values,
      .folds = std::min(options.folds, static_cast<int>(response.values.size()))};
  std::vector<SurrogateScore> scores;
  for (const std::string& name : SurrogateNames()) {
    if (before_each) before_each(name);
    comparison.surrogates.push_back(Assess(name, response, options, comparison.folds));
    const SurrogateAccuracy& last = comparison.surrogates.back();
    if (last.why_not.empty()) scores.push_back({.name = name, .r2 = last.leave_one_out.r2});
  }
  if (!scores.empty()) comparison.best = BestOf(scores).name;
  return comparison;
}

}  // namespace powdercal
