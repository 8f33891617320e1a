#include "cli/collapse.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/parameters.h"
#include "cli/signals.h"
#include "cli/text.h"
#include "core/files.h"
#include "core/quantity.h"
#include "core/statistics.h"
#include "reports/collapse_html.h"
#include "reports/text.h"
#include "studies/collapse.h"
#include "studies/executor.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

// False if it was stopped: what had not ended has failed.
bool Simulate(const Study& study, Collapse* collapse) {
  const Planner planner(study);
  const std::filesystem::path folder = MakeTemporaryFolder();
  SignalStop signals;
  LocalExecutor executor(study.parallel());
  std::vector<CollapsePoint*> owners;
  for (CollapsePoint& point : collapse->points()) {
    for (const PlannedRun& run : point.runs) {
      RunContext context{.work_folder = folder / std::to_string(owners.size())};
      if (study.budget.run_timeout) {
        context.time_limit = std::chrono::duration<double>(*study.budget.run_timeout);
      }
      executor.Submit(static_cast<std::int64_t>(owners.size()),
                      [&planner, run, context](std::stop_token stop) mutable {
                        context.stop = std::move(stop);
                        return planner.Execute(run, context);
                      });
      owners.push_back(&point);
    }
  }
  for (std::size_t done = 0; done < owners.size();) {
    if (signals.token().stop_requested()) executor.Cancel();
    const auto finished = executor.Wait(std::chrono::milliseconds(200));
    if (!finished) continue;
    ++done;
    CollapsePoint& point = *owners[static_cast<std::size_t>(finished->ticket)];
    Keep(finished->run, &point);
    Say("  {}/{} {} at E = {}, {}: {}, {}\n", done, owners.size(), finished->run.experiment,
        HumanQuantity(point.young_modulus, "Pa", 3), point.mode,
        ToString(finished->run.outcome.reason), DurationText(finished->run.total_seconds));
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return !signals.token().stop_requested();
}

std::string Group(const CollapsePoint& point, const char* symbol) {
  const auto found = point.groups.find(symbol);
  return found == point.groups.end() ? "-" : fmt::format("{:.3g}", found->second);
}

std::string MeanText(const std::vector<double>& values) {
  const std::string mean = fmt::format("{:.4g}", Mean(values));
  return values.size() < 2 ? mean : fmt::format("{} ± {:.2g}", mean, StandardDeviation(values));
}

void PrintPoints(const Study& study, const std::vector<CollapsePoint>& points) {
  for (std::size_t e = 0; e < study.experiments.size(); ++e) {
    std::vector<std::vector<std::string>> rows;
    for (const CollapsePoint& point : points) {
      if (point.experiment != e) continue;
      if (rows.empty()) {
        rows.push_back({"mode", "E", "kappa", "sigma/(rho_b g h)", "F_c/(sigma d^2)", "Bo"});
        for (const auto& [response, values] : point.responses) rows[0].push_back(response);
      }
      rows.push_back({point.mode, HumanQuantity(point.young_modulus, "Pa", 3),
                      Group(point, "kappa"), Group(point, "sigma/(rho_b g h)"),
                      Group(point, "F_c/(sigma d^2)"), Group(point, "Bo")});
      for (std::size_t c = 6; c < rows[0].size(); ++c) {
        const auto found = point.responses.find(rows[0][c]);
        rows.back().push_back(found == point.responses.end() ? "failed" : MeanText(found->second));
      }
    }
    if (rows.empty()) continue;
    Print("\n# {}: mean ± standard deviation between seeds\n{}", study.experiments[e].name(),
          AlignedTable(rows));
    for (const CollapsePoint& point : points) {
      if (point.experiment != e || point.failures.empty()) continue;
      Print("  note: {} of {} runs of {} at E = {} failed: {}\n", point.failures.size(),
            point.runs.size(), point.mode, HumanQuantity(point.young_modulus, "Pa", 3),
            point.failures.front());
    }
  }
}

std::string PlateauText(const Plateau& plateau) {
  if (plateau.kappa == 0) {
    return fmt::format("still changes at the largest stiffness, kappa = {:.4g}",
                       plateau.largest_kappa);
  }
  return fmt::format("constant from kappa = {:.4g} to {:.4g}", plateau.kappa,
                     plateau.largest_kappa);
}

void PrintFindings(const std::vector<GroupTrend>& trends, const std::vector<Plateau>& plateaus) {
  Print("\n# from which stiffness on rigid_limit gives the same, within two standard errors\n");
  std::vector<std::vector<std::string>> rows;
  for (const Plateau& plateau : plateaus) {
    rows.push_back({plateau.experiment + "." + plateau.response, PlateauText(plateau),
                    fmt::format("change {:+.2g} ± {:.2g}", plateau.change, plateau.error)});
  }
  Print("{}", AlignedTable(rows));
  Print("\n# which groups the responses follow, over all modes (1: that group alone)\n");
  rows = {{"response", "group", "collapse", "change per factor of e"}};
  for (const GroupTrend& trend : trends) {
    rows.push_back({trend.experiment + "." + trend.response, trend.group,
                    fmt::format("{:.2f}", trend.collapse),
                    fmt::format("{:+.2g} ± {:.2g}", trend.slope, trend.slope_error)});
  }
  Print("{}", AlignedTable(rows));
}

json ToJson(const Study& study, const Collapse& collapse, const std::vector<GroupTrend>& trends,
            const std::vector<Plateau>& plateaus) {
  json document = {{"schema", 1},
                   {"study", study.name},
                   {"points", json::array()},
                   {"trends", json::array()},
                   {"plateaus", json::array()}};
  for (const CollapsePoint& point : collapse.points()) {
    document["points"].push_back({{"mode", point.mode},
                                  {"experiment", study.experiments[point.experiment].name()},
                                  {"young_modulus", point.young_modulus},
                                  {"groups", point.groups},
                                  {"responses", point.responses},
                                  {"failures", point.failures}});
  }
  for (const GroupTrend& trend : trends) {
    document["trends"].push_back({{"response", trend.experiment + "." + trend.response},
                                  {"group", trend.group},
                                  {"collapse", trend.collapse},
                                  {"slope", trend.slope},
                                  {"slope_error", trend.slope_error},
                                  {"points", trend.points}});
  }
  for (const Plateau& plateau : plateaus) {
    json kappa;
    if (plateau.kappa > 0) kappa = plateau.kappa;
    document["plateaus"].push_back({{"response", plateau.experiment + "." + plateau.response},
                                    {"seed_sd", plateau.seed_sd},
                                    {"kappa", kappa},
                                    {"largest_kappa", plateau.largest_kappa},
                                    {"change", plateau.change},
                                    {"error", plateau.error}});
  }
  return document;
}

}  // namespace

int RunCollapse(const Study& study, const CollapseCommand& command) {
  const Planner planner(study);
  const Backend& backend = *study.backend.backend;
  if (!planner.availability().available || !backend.simulates()) {
    throw InputError(
        fmt::format("backend '{}' {}", backend.name(),
                    backend.simulates() ? "is not available: " + planner.availability().why_not
                                        : std::string("simulates nothing to collapse")),
        {.location = {study.file}});
  }
  CollapseOptions options{.replicates = command.replicates,
                          .experiments = ReadExperiments(study, command.experiments),
                          .parameters = command.parameters};
  if (!command.kappas.empty()) options.kappas = command.kappas;
  std::sort(options.kappas.begin(), options.kappas.end());
  if (!command.folder.empty()) std::filesystem::create_directories(command.folder);
  Collapse collapse(study, std::move(options));
  const bool complete = Simulate(study, &collapse);
  const std::vector<GroupTrend> trends = FindTrends(study, collapse.points());
  const std::vector<Plateau> plateaus = FindPlateaus(study, collapse.points());
  const json document = ToJson(study, collapse, trends, plateaus);
  if (command.json) {
    Print("{}\n", document.dump(2));
  } else {
    PrintPoints(study, collapse.points());
    PrintFindings(trends, plateaus);
  }
  if (!command.folder.empty()) {
    const std::filesystem::path folder = command.folder;
    WriteFileAtomically(folder / "collapse.json", document.dump(2) + "\n");
    WriteFileAtomically(folder / "collapse.html", CollapseHtml(document));
    Say("plots: {}\n", (folder / "collapse.html").string());
  }
  if (!complete) return kInterrupted;
  return plateaus.empty() ? kFellShort : kDone;
}

}  // namespace powdercal::cli
