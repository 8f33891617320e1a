#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "reports/html_sections.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal {
namespace {

std::string Header(const std::string& markup, bool number, std::string_view unit = "") {
  const std::string pretty = PrettyUnit(unit);
  return fmt::format("<th{}>{}{}</th>", number ? " class=\"number\"" : "", markup,
                     pretty.empty() ? "" : " (" + H(pretty) + ")");
}

// data-sort holds the exact number, for sorting and for whoever wants more digits.
// The simulated value in its display unit.
std::optional<double> Displayed(const ResponseResult& response) {
  if (!response.simulated) return std::nullopt;
  return *response.simulated * DisplayUnitOf(response.unit).per_si;
}

std::string NumberCell(std::optional<double> value, int digits, const std::string& suffix = "") {
  if (!value || !std::isfinite(*value)) return "<td class=\"number\" data-sort=\"\">—</td>";
  return fmt::format("<td class=\"number\" data-sort=\"{}\">{}{}</td>", *value,
                     H(NumberText(*value, digits)), suffix);
}

std::string TextCell(std::string_view text, std::string_view css = "") {
  return fmt::format("<td{}>{}</td>", css.empty() ? "" : fmt::format(" class=\"{}\"", css),
                     H(text));
}

std::string OutcomeTag(const std::string& outcome) {
  if (outcome == kPartial) return "<span class=\"tag off\">✕ in part</span>";
  return outcome == "ok"
             ? std::string("<span class=\"tag good\">ok</span>")
             : fmt::format("<span class=\"tag bad\">✕ {}</span>", H(ReadableName(outcome)));
}

std::string ParameterCell(const Parameter& parameter, std::optional<double> value) {
  if (value && parameter.categorical()) return TextCell(parameter.CategoryAt(*value));
  return NumberCell(value, 5);
}

bool IsLower(const StudyResults& results, const EvaluationResult& evaluation) {
  return !evaluation.fidelity.empty() && evaluation.fidelity != results.fidelity;
}

std::string EvaluationRow(const StudyResults& results, const EvaluationResult& evaluation,
                          std::size_t targets, bool best) {
  std::string html = best                         ? "<tr class=\"best\">"
                     : evaluation.outcome == "ok" ? "<tr>"
                                                  : "<tr class=\"failed\">";
  html += fmt::format("<td class=\"number\" data-sort=\"{0}\">{0}{1}</td>", evaluation.id,
                      best ? " <strong>★ best</strong>" : "");
  if (IsLower(results, evaluation)) html += TextCell(evaluation.fidelity);
  for (const Parameter& parameter : results.parameters) {
    const auto found = evaluation.parameters.find(parameter.name);
    html += ParameterCell(parameter, found == evaluation.parameters.end()
                                         ? std::nullopt
                                         : std::optional<double>(found->second));
  }
  for (std::size_t i = 0; i < targets; ++i) {
    if (i >= evaluation.responses.size()) {
      html += NumberCell(std::nullopt, 4);
      continue;
    }
    const ResponseResult& response = evaluation.responses[i];
    const double sd = response.seed_sd * DisplayUnitOf(response.unit).per_si;
    html += NumberCell(
        Displayed(response), 4,
        response.replicates > 1
            ? fmt::format(" <span class=\"muted small\">± {}</span>", H(NumberText(sd, 2)))
            : "");
  }
  html += NumberCell(evaluation.chi2, 3);
  html += fmt::format("<td>{}</td>", OutcomeTag(evaluation.outcome));
  html += TextCell(evaluation.origin);
  double seconds = 0;
  for (const RunResult& run : evaluation.runs) seconds += run.wall_seconds;
  html += NumberCell(evaluation.runs.empty() ? std::nullopt : std::optional(seconds), 3);
  html += TextCell(evaluation.message, "message");
  return html + "</tr>\n";
}

// `evaluations`: at least one; all at the study's fidelity, or all below it.
std::string EvaluationTable(const StudyResults& results,
                            const std::vector<EvaluationResult>& evaluations, std::string_view id) {
  const std::vector<ResponseResult> targets = TargetResponses(results);
  std::string html = fmt::format(
      "<div class=\"scroll\"><table class=\"sortable\" id=\"{}\"><thead><tr>"
      "<th class=\"number\" aria-sort=\"ascending\">#</th>",
      id);
  if (IsLower(results, evaluations.front())) html += Header("fidelity", false);
  for (const Parameter& parameter : results.parameters) {
    html += Header(SymbolHtml(parameter.symbol), true, parameter.unit);
  }
  for (const ResponseResult& target : targets) {
    html += Header(H(ReadableName(target.name)), true, DisplayUnitOf(target.unit).name);
  }
  html += Header("χ²", true) + Header("outcome", false) + Header("proposed by", false) +
          Header("wall (s)", true) + Header("message", false) + "</tr></thead><tbody>\n";
  for (const EvaluationResult& evaluation : evaluations) {
    const bool best = &evaluation == BestEvaluation(results);
    html += EvaluationRow(results, evaluation, targets.size(), best);
  }
  return html + "</tbody></table></div>\n";
}

std::string RunRow(std::int64_t evaluation, const RunResult& run) {
  std::string row = run.reason == "ok" ? "<tr>" : "<tr class=\"failed\">";
  row +=
      fmt::format("<td class=\"number\">{}</td><td class=\"number\">{}</td>", run.id, evaluation);
  row += TextCell(run.experiment) + TextCell(run.backend) +
         fmt::format("<td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td>",
                     run.replicate, run.seed, OutcomeTag(run.reason));
  row += NumberCell(run.wall_seconds, 3) +
         fmt::format("<td class=\"hash\" title=\"{}\">{}</td>", H(run.program_hash),
                     H(std::string_view(run.program_hash).substr(0, 12)));
  return row + TextCell(run.message, "message") + "</tr>\n";
}

// "all", "consolidation, shear", "none".
std::string FittedObjectives(const StudyResults& results, const EvaluationResult& evaluation) {
  std::string list;
  std::size_t fitted = 0;
  for (std::size_t o = 0; o < results.objectives.size(); ++o) {
    if (!FitsObjective(results, evaluation, o)) continue;
    ++fitted;
    list += (list.empty() ? "" : ", ") + ReadableName(results.objectives[o]);
  }
  if (fitted == results.objectives.size()) return "all";
  return list.empty() ? "none" : list;
}

std::string FrontRow(const StudyResults& results, const EvaluationResult& evaluation) {
  const bool best = &evaluation == BestEvaluation(results);
  std::string html = fmt::format("<tr{0}><td class=\"number\" data-sort=\"{1}\">{1}{2}</td>",
                                 best ? " class=\"best\"" : "", evaluation.id,
                                 best ? " <strong>★ best</strong>" : "");
  for (const ObjectiveResult& objective : evaluation.objectives) {
    html += NumberCell(objective.misfit, 3);
  }
  html += TextCell(FittedObjectives(results, evaluation));
  for (const Parameter& parameter : results.parameters) {
    html += ParameterCell(parameter, evaluation.parameters.at(parameter.name));
  }
  for (const ResponseResult& response : evaluation.responses) {
    html += NumberCell(Displayed(response), 4);
  }
  return html + "</tr>\n";
}

std::string FrontTable(const StudyResults& results) {
  std::string html =
      "<div class=\"scroll\"><table class=\"sortable\" id=\"front\"><thead><tr>"
      "<th class=\"number\">#</th>";
  for (std::size_t o = 0; o < results.objectives.size(); ++o) {
    html += fmt::format(
        "<th class=\"number\"{}>misfit<br><span class=\"small muted\">{}</span></th>",
        o == 0 ? " aria-sort=\"ascending\"" : "", H(ReadableName(results.objectives[o])));
  }
  html += Header("fits", false);
  for (const Parameter& parameter : results.parameters) {
    html += Header(SymbolHtml(parameter.symbol), true, parameter.unit);
  }
  for (const ResponseResult& target : TargetResponses(results)) {
    html += fmt::format(
        "<th class=\"number\">{}<br><span class=\"small muted\">{}, observed {}</span></th>",
        H(ReadableName(target.name)), H(ReadableName(target.name.substr(0, target.name.find('.')))),
        H(ValueText(target.observed, target.unit)));
  }
  html += "</tr></thead><tbody>\n";
  std::vector<std::size_t> front = results.pareto;
  std::stable_sort(front.begin(), front.end(), [&](std::size_t a, std::size_t b) {
    return results.history[a].objectives[0].misfit < results.history[b].objectives[0].misfit;
  });
  for (const std::size_t index : front) html += FrontRow(results, results.history[index]);
  return html + "</tbody></table></div>\n";
}

std::string RunsTable(const StudyResults& results) {
  std::string rows;
  int count = 0;
  const auto add = [&](const EvaluationResult& evaluation, const std::vector<RunResult>& runs) {
    for (const RunResult& run : runs) rows += RunRow(evaluation.id, run);
    count += static_cast<int>(runs.size());
  };
  for (const EvaluationResult& evaluation : results.history) add(evaluation, evaluation.runs);
  for (const EvaluationResult& evaluation : results.lower_fidelity) {
    add(evaluation, evaluation.runs);
  }
  if (const EvaluationResult* best = BestEvaluation(results)) {
    for (const ConfirmationResult& confirmation : results.confirmations) {
      add(*best, confirmation.runs);
    }
    if (results.approximation_effect) add(*best, results.approximation_effect->runs);
    add(*best, results.transfer.runs);
  }
  if (count == 0) return "";
  return fmt::format(
      "<details><summary>{} behind these evaluations</summary>\n<div class=\"scroll\">"
      "<table class=\"sortable\"><thead><tr><th class=\"number\">run</th>"
      "<th class=\"number\">evaluation</th><th>experiment</th><th>backend</th><th "
      "class=\"number\">replicate</th>"
      "<th class=\"number\">particle seed</th><th>outcome</th><th class=\"number\">wall (s)</th>"
      "<th>program</th><th>message</th></tr></thead><tbody>\n{}</tbody></table></div></details>\n",
      CountText(count, results.simulated ? "simulation" : "answer"), rows);
}

// What else was measured in the simulations of the best point.
std::string DiagnosticsTable(const std::vector<RunResult>& runs) {
  std::set<std::string> names;
  std::string head = "<th>diagnostic (SI)</th>";
  for (const RunResult& run : runs) {
    for (const auto& [name, value] : run.diagnostics) names.insert(name);
    head += fmt::format("<th class=\"number\">{}, seed {}</th>", H(run.experiment), run.seed);
  }
  if (names.empty()) return "";
  std::string rows;
  for (const std::string& name : names) {
    rows += "<tr>" + TextCell(ReadableName(name));
    for (const RunResult& run : runs) {
      const auto found = run.diagnostics.find(name);
      rows += NumberCell(
          found == run.diagnostics.end() ? std::nullopt : std::optional<double>(found->second), 5);
    }
    rows += "</tr>\n";
  }
  return fmt::format(
      "<details><summary>Diagnostics of the best point's runs</summary>\n<div class=\"scroll\">"
      "<table><thead><tr>{}</tr></thead><tbody>\n{}</tbody></table></div></details>\n",
      head, rows);
}

}  // namespace

std::string ParetoSection(const StudyResults& results, const std::vector<Figure>& figures) {
  if (results.objectives.size() < 2 || results.pareto.empty()) return "";
  const Compatibility compatibility = JudgeCompatibility(results);
  std::string html = fmt::format(
      "<section><h2>What fits together</h2>\n<p><strong>{}</strong> {}</p>\n"
      "<div class=\"figures\">\n",
      H(compatibility.statement), H(compatibility.detail));
  for (const Figure& figure : figures) html += FigureElement(figure);
  html += fmt::format(
      "</div>\n<h3>The front: {} no other evaluation beats in every experiment</h3>\n{}",
      results.pareto.size() == 1 ? "the evaluation that"
                                 : fmt::format("{} evaluations that", results.pareto.size()),
      FrontTable(results));
  return html +
         "<p class=\"muted small\">The misfit of an experiment is the χ² that its responses are "
         "expected to have, the scatter between particle seeds added to their deviations: as many "
         "as it has responses where each is one standard deviation off. The best point of this "
         "report is the one with the lowest sum, which is one choice among these.</p></section>\n";
}

std::string EvaluationsSection(const StudyResults& results) {
  std::string html = "<section><h2>Evaluations</h2>\n";
  if (results.history.empty() && results.lower_fidelity.empty()) {
    return html + "<p class=\"muted\">No evaluation has ended yet.</p></section>\n";
  }
  if (!results.history.empty()) html += EvaluationTable(results, results.history, "evaluations");
  html += "<p class=\"muted small\">Click a column's head to sort.</p>\n";
  if (!results.lower_fidelity.empty()) {
    html += fmt::format(
        "<details><summary>{} at a lower fidelity, from which the optimizer learnt</summary>\n"
        "<p class=\"muted small\">Smaller simulations of the same experiments. They are not "
        "ranked, and nothing else in this report rests on them.</p>\n{}</details>\n",
        CountText(static_cast<int>(results.lower_fidelity.size()), "evaluation"),
        EvaluationTable(results, results.lower_fidelity, "lower_fidelity"));
  }
  html += RunsTable(results);
  if (const EvaluationResult* best = BestEvaluation(results)) {
    std::vector<RunResult> runs = best->runs;
    runs.insert(runs.end(), results.transfer.runs.begin(), results.transfer.runs.end());
    html += DiagnosticsTable(runs);
  }
  return html + "</section>\n";
}

}  // namespace powdercal
