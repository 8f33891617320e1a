#include "cli/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal::cli {
namespace {

// Characters, not bytes, of UTF-8; colours take no room.
std::size_t Width(const std::string& text) {
  std::size_t width = 0;
  bool escape = false;
  for (const char c : text) {
    if (c == '\x1b') escape = true;
    if (!escape && (static_cast<unsigned char>(c) & 0xC0) != 0x80) ++width;
    if (c == 'm') escape = false;
  }
  return width;
}

std::string Response(const ResponseResult& response, bool fitted) {
  if (!response.simulated) return fmt::format("  {}: no value\n", response.name);
  const DisplayUnit unit = DisplayUnitOf(response.unit);
  std::string text = fmt::format("  {} = {:.4g}", response.name, *response.simulated * unit.per_si);
  if (unit.name != "1") text += fmt::format(" {}", unit.name);
  if (response.replicates > 1) {
    text += fmt::format(" (mean of {} seeds, standard deviation {:.2g})", response.replicates,
                        response.seed_sd * unit.per_si);
  }
  if (!response.was_observed()) return text + ", not observed\n";
  const double deviation = *response.simulated - response.observed;
  text += fmt::format(", observed {:.4g} ± {:.2g}, off by {:+.2g}", response.observed * unit.per_si,
                      response.sd * unit.per_si, deviation * unit.per_si);
  if (!fitted) text += fmt::format(" ({:.2g} sd)", std::abs(*StandardDeviationsOff(response)));
  if (response.tolerance) {
    text += fmt::format(": {} the tolerance of {:.2g}",
                        std::abs(deviation) < *response.tolerance ? "within" : "NOT within",
                        *response.tolerance * unit.per_si);
  }
  return text + "\n";
}

}  // namespace

std::string HumanValue(const Parameter& parameter, double value) {
  return parameter.categorical() ? parameter.CategoryAt(value)
                                 : HumanQuantity(value, parameter.unit);
}

std::string DescribePoint(const std::vector<Parameter>& parameters,
                          const std::vector<double>& values) {
  std::string text;
  for (std::size_t i = 0; i < parameters.size() && i < values.size(); ++i) {
    if (i > 0) text += ", ";
    text += fmt::format("{} = {}", parameters[i].symbol, HumanValue(parameters[i], values[i]));
  }
  return text;
}

std::string AlignedTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], Width(row[i]));
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += "  " + row[i];
      if (i + 1 < row.size()) line += std::string(widths[i] - Width(row[i]), ' ');
    }
    text += line + "\n";
  }
  return text;
}

std::string Summary(const StudyResults& results) {
  const std::string partly =
      results.partial > 0 ? fmt::format("{} partly failed, ", results.partial) : "";
  const std::string lower = LowerFidelityText(results);
  std::string text = fmt::format("{}: {} evaluations{}, {} ok, {}{} failed; {}\n", results.study,
                                 results.total, lower.empty() ? "" : " (" + lower + ")", results.ok,
                                 partly, results.failed, results.stop_reason);
  if (results.best) {
    const EvaluationResult& best = results.history[*results.best];
    text += "best:\n";
    for (const Parameter& parameter : results.parameters) {
      text += fmt::format("  {} ({}) = {}\n", parameter.name, parameter.symbol,
                          HumanValue(parameter, best.parameters.at(parameter.name)));
    }
    for (const ResponseResult& response : best.responses) text += Response(response, true);
    text += fmt::format("  chi2 = {:.3g}\n", best.chi2.value_or(0));
    if (results.approximation_effect) {
      text += "what the approximation of the contact law changes:\n";
      for (const std::string& statement : ApproximationStatements(results)) {
        text += "  " + statement + "\n";
      }
    }
    for (const ConfirmationResult& confirmation : results.confirmations) {
      text += "on " + confirmation.backend + ":\n";
      for (const ResponseResult& response : confirmation.responses) {
        if (response.simulated) text += Response(response, true);
      }
      for (const std::string& statement : ConfirmationStatements(results, confirmation)) {
        text += "  " + statement + "\n";
      }
      if (confirmation.chi2) text += fmt::format("  chi2 = {:.3g}\n", *confirmation.chi2);
      text += "  " + ConfirmationHeadline(results, confirmation) + "\n";
    }
    if (!results.transfer.experiments.empty()) {
      text += "the best point on what was not fitted:\n";
      for (const ResponseResult& response : results.transfer.responses) {
        text += Response(response, false);
      }
      for (const ExperimentFailure& failure : results.transfer.failures) {
        text += fmt::format("  {} failed in {} of {} runs, {}: {}\n", failure.experiment,
                            failure.failed_runs, failure.runs, failure.reason, failure.message);
      }
      text += "  " + TransferHeadline(results) + "\n";
    }
  } else {
    text +=
        results.partial > 0 ? "no evaluation gave every response\n" : "no evaluation succeeded\n";
  }
  for (const std::string& caveat : Caveats(results)) text += "note: " + caveat + "\n";
  const double wall = std::max(results.wall_seconds, 1e-9);
  text +=
      fmt::format("time: {} wall clock, {} inside simulators on {} at a time", DurationText(wall),
                  DurationText(results.simulation_seconds), results.parallel);
  if (results.simulated) {
    text += fmt::format(", {:.2f} % overhead", 100 * results.overhead_seconds / wall);
  }
  return text + "\n";
}

}  // namespace powdercal::cli
