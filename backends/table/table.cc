#include "backends/table/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/errors.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/quantity.h"
#include "surrogates/validation.h"

namespace powdercal {
namespace {

constexpr std::size_t kFewestRows = 3;
constexpr double kToleratedExtrapolation = 0.1;  // of the data's own range

// The study's line is the one to correct, so the error stands there.
std::string ReadTable(const std::filesystem::path& path, InputError::Details place) {
  try {
    return ReadFile(path);
  } catch (const InputError& error) {
    place.value = path.string();
    throw InputError(fmt::format("table '{}': {}", path.string(), error.problem()),
                     std::move(place));
  }
}

std::pair<double, double> MinMax(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
}

// Everything without a dot in its name, other than the study's parameters, is taken for an input.
std::vector<std::string> WarnOfIgnoredInputs(const BackendProblem& problem, const Table& table) {
  std::vector<std::string> warnings;
  for (const Table::Column& column : table.columns()) {
    const bool free = std::any_of(problem.parameters.begin(), problem.parameters.end(),
                                  [&](const auto& p) { return p.name == column.name; });
    const auto [low, high] = MinMax(column.values);
    if (free || low == high || column.name.find('.') != std::string::npos) continue;
    warnings.push_back(fmt::format(
        "{}: column '{}' varies but is no free parameter of the study; its influence is "
        "not modelled",
        table.file(), column.name));
  }
  return warnings;
}

}  // namespace

void TableBackend::Options::Serialize(Archive& archive) {
  archive.Require("file");
  archive.Text("file", file);
  std::vector<std::string> valid(SurrogateNames().begin(), SurrogateNames().end());
  valid.insert(valid.begin(), kBest);  // stays sorted
  archive.Choice("surrogate", surrogate, "surrogate", valid);
}

const std::string& TableBackend::name() const {
  static const std::string name = "table";
  return name;
}

Availability TableBackend::availability() const { return {.available = true, .version = "1"}; }

void TableBackend::Serialize(Archive& archive) {
  options_.Serialize(archive);
  if (archive.reading()) place_ = archive.ErrorAt("file", "").details();
}

std::vector<std::string> TableBackend::Prepare(const BackendProblem& problem) {
  const std::filesystem::path path = problem.base_folder / options_.file;
  const std::string text = ReadTable(path, place_);
  const Table table = Table::ParseCsv(text, path.string());
  if (table.row_count() < kFewestRows) {
    throw InputError(fmt::format("the table has {} rows; a surrogate needs at least {}",
                                 table.row_count(), kFewestRows),
                     {.location = {path.string()}});
  }
  std::vector<std::string> warnings = FindBox(problem, table);
  FitResponses(problem, table);

  fingerprint_ = FingerprintOf(text);

  const std::vector<std::string> ignored = WarnOfIgnoredInputs(problem, table);
  warnings.insert(warnings.end(), ignored.begin(), ignored.end());
  return warnings;
}

std::string TableBackend::FingerprintOf(const std::string& text) const {
  std::string key = Sha256(text) + "\n" + options_.surrogate;
  if (options_.surrogate == kBest) key += "\n" + Describe();
  for (const auto& p : box_)
    key += fmt::format("\n{} [{}] {} {}", p.name, p.unit, p.lower, p.upper);
  return Sha256(key);
}

std::string TableBackend::Describe() const {
  std::vector<std::string> parts;
  for (const auto& [response, surrogate] : responses_) {
    parts.push_back(response + " by " + surrogate->name());
  }
  return JoinNames(parts);
}

std::vector<std::string> TableBackend::FindBox(const BackendProblem& problem, const Table& table) {
  std::vector<std::string> warnings;
  box_.clear();
  for (BackendProblem::FreeParameter parameter : problem.parameters) {
    const auto [low, high] = MinMax(table.Get(parameter.name, parameter.unit).values);
    const double slack = kToleratedExtrapolation * (high - low);
    if (parameter.lower < low - slack || parameter.upper > high + slack) {
      warnings.push_back(fmt::format(
          "{}: the study searches {} from {} to {}, the table knows it from {} to {} only; the "
          "surrogate extrapolates",
          table.file(), parameter.name, HumanQuantity(parameter.lower, parameter.unit),
          HumanQuantity(parameter.upper, parameter.unit), HumanQuantity(low, parameter.unit),
          HumanQuantity(high, parameter.unit)));
    }
    parameter.lower = std::min(parameter.lower, low);
    parameter.upper = std::max(parameter.upper, high);
    box_.push_back(std::move(parameter));
  }
  return warnings;
}

void TableBackend::FitResponses(const BackendProblem& problem, const Table& table) {
  const auto rows = static_cast<Eigen::Index>(table.row_count());
  Eigen::MatrixXd points(rows, static_cast<Eigen::Index>(box_.size()));
  for (std::size_t j = 0; j < box_.size(); ++j) {
    const std::vector<double>& values = table.Get(box_[j].name, box_[j].unit).values;
    const double width = box_[j].upper - box_[j].lower;
    for (Eigen::Index i = 0; i < rows; ++i) {
      points(i, static_cast<Eigen::Index>(j)) =
          (values[static_cast<std::size_t>(i)] - box_[j].lower) / width;
    }
  }
  responses_.clear();
  for (const auto& response : problem.responses) {
    const std::vector<double>& values = table.Get(response.name, response.unit).values;
    const Eigen::VectorXd column = Eigen::Map<const Eigen::VectorXd>(values.data(), rows);
    auto surrogate = MakeSurrogate(options_.surrogate == kBest ? SelectBest(points, column).name
                                                               : options_.surrogate);
    surrogate->Fit(points, column, {});
    responses_[response.name] = std::move(surrogate);
  }
}

std::string TableBackend::ExplainUnsupported(const Program& program) const {
  if (fingerprint_.empty()) return "the table has not been read";
  const std::string prefix = program.experiment + ".";
  const bool known = std::any_of(responses_.begin(), responses_.end(), [&](const auto& response) {
    return response.first.starts_with(prefix);
  });
  if (!known) {
    return fmt::format("{} was not asked for any response of the experiment '{}'", options_.file,
                       program.experiment);
  }
  for (const auto& parameter : box_) {
    if (!program.parameters.contains(parameter.name)) {
      return fmt::format("the program does not say its parameter '{}'", parameter.name);
    }
  }
  return "";
}

Eigen::VectorXd TableBackend::ToBox(const Program& program) const {
  Eigen::VectorXd point(static_cast<Eigen::Index>(box_.size()));
  for (std::size_t j = 0; j < box_.size(); ++j) {
    point[static_cast<Eigen::Index>(j)] =
        (program.parameters.at(box_[j].name) - box_[j].lower) / (box_[j].upper - box_[j].lower);
  }
  return point;
}

Trace TableBackend::Run(const Program& program, const RunContext&) const {
  const auto start = std::chrono::steady_clock::now();
  Trace trace;
  trace.diagnostics.law = fmt::format("none: {}; no simulation was run", options_.file);
  if (const std::string reason = ExplainUnsupported(program); !reason.empty()) {
    trace.outcome = {Reason::unsupported, reason};
    return trace;
  }
  const Eigen::VectorXd point = ToBox(program);
  const std::string prefix = program.experiment + ".";
  std::vector<std::string> used;
  for (const auto& [name, surrogate] : responses_) {
    if (!name.starts_with(prefix)) continue;
    if (std::find(used.begin(), used.end(), surrogate->name()) == used.end()) {
      used.push_back(surrogate->name());
    }
    const Prediction prediction = surrogate->Predict(point);
    const std::string response = name.substr(prefix.size());
    trace.reported[response] = {.value = prediction.mean, .variance = 0};
    trace.diagnostics.figures[response + ".surrogate_sd"] =
        std::sqrt(std::max(0.0, prediction.variance));
  }
  trace.diagnostics.law =
      fmt::format("none: {} of {}; no simulation was run", JoinNames(used), options_.file);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  trace.diagnostics.wall_seconds = wall.count();
  return trace;
}

}  // namespace powdercal
