#include "reports/html_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/errors.h"
#include "reports/statements.h"
#include "reports/text.h"

namespace powdercal {
namespace {

std::string Value(double value, const std::string& unit, int digits = 4) {
  return H(ValueText(value, unit, digits));
}

std::string Entry(std::string_view term, const std::string& markup) {
  return markup.empty() ? "" : fmt::format("<dt>{}</dt><dd>{}</dd>\n", H(term), markup);
}

// "μᵣ rolling friction"; the name alone where there is no symbol of its own.
std::string ParameterName(const Parameter& parameter) {
  const std::string name = H(ReadableName(parameter.name));
  const std::string symbol = SymbolHtml(parameter.symbol);
  if (symbol.empty() || symbol == name) return name;
  return fmt::format("<strong>{}</strong>, {}", symbol, name);
}

std::string ParametersCard(const StudyResults& results) {
  const EvaluationResult* best = BestEvaluation(results);
  const bool calibrated = Conclude(results).kind == Conclusion::Kind::fits;
  std::string html =
      fmt::format("<section class=\"card parameters\"><h3>{} parameters</h3>\n<table>\n",
                  calibrated ? "Calibrated" : "Best") +
      "<thead><tr><th>parameter</th><th class=\"number\">value</th>"
      "<th class=\"number\">searched</th></tr></thead><tbody>\n";
  for (const Parameter& parameter : results.parameters) {
    std::string value = "none";
    if (best != nullptr) {
      const auto found = best->parameters.find(parameter.name);
      if (found != best->parameters.end()) {
        value = parameter.categorical() ? H(parameter.CategoryAt(found->second))
                                        : Value(found->second, parameter.unit);
      }
    }
    const std::string searched = parameter.categorical()
                                     ? H(Enumerated(parameter.categories))
                                     : fmt::format("{} – {}", H(NumberText(parameter.lower)),
                                                   H(ValueText(parameter.upper, parameter.unit)));
    html += fmt::format(
        "<tr><td>{}</td><td class=\"number value\">{}</td>"
        "<td class=\"number small\">{}</td></tr>\n",
        ParameterName(parameter), value, searched);
  }
  html += "</tbody></table>\n";
  if (best != nullptr) {
    html += fmt::format(
        "<p class=\"muted small\">Evaluation {}. No uncertainty of the parameters was "
        "estimated.</p>\n",
        best->id);
  }
  return html + "</section>\n";
}

std::string SimulatedCell(const ResponseResult& response) {
  if (!response.simulated) return "none";
  std::string text =
      fmt::format("<span class=\"value\">{}</span>", Value(*response.simulated, response.unit));
  if (response.replicates > 1) {
    text += fmt::format("<br><span class=\"small muted\">± {} over {} seeds</span>",
                        H(NumberText(response.seed_sd * DisplayUnitOf(response.unit).per_si, 2)),
                        response.replicates);
  }
  return text;
}

std::string FitRow(const ResponseResult& response) {
  const Fit fit = JudgeFit(response);
  const std::size_t dot = response.name.rfind('.');
  const std::string experiment =
      dot == std::string::npos ? "" : ReadableName(response.name.substr(0, dot));
  if (!response.was_observed()) {
    return fmt::format(
        "<tr><td><strong>{}</strong><br><span class=\"small muted\">{}</span></td>"
        "<td class=\"number\">{}</td><td class=\"number\">—</td><td class=\"number\">—</td>"
        "<td><span class=\"tag unknown\">not observed</span></td></tr>\n",
        H(ReadableName(response.name)), H(experiment), SimulatedCell(response));
  }
  const std::string limit = fmt::format("±&nbsp;{}{}", Value(fit.limit, response.unit, 2),
                                        fit.has_tolerance ? "" : " (2&nbsp;sd)");
  std::string deviation = "none";
  std::string verdict = "<span class=\"tag bad\">no value</span>";
  if (fit.deviation) {
    deviation = (*fit.deviation > 0 ? "+" : "") + Value(*fit.deviation, response.unit, 2);
    verdict = fit.within ? fmt::format("<span class=\"tag good\">within {}</span>", limit)
                         : fmt::format("<span class=\"tag bad\">outside {}</span>", limit);
  }
  return fmt::format(
      "<tr><td><strong>{}</strong><br><span class=\"small muted\">{}</span></td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}<br>"
      "<span class=\"small muted\">± {}</span></td><td class=\"number\">{}</td><td>{}</td></tr>\n",
      H(ReadableName(response.name)), H(experiment), SimulatedCell(response),
      Value(response.observed, response.unit), Value(response.sd, response.unit, 2), deviation,
      verdict);
}

std::string ResponsesTable(const StudyResults& results,
                           const std::vector<ResponseResult>& responses) {
  std::string html = fmt::format(
      "<table>\n<thead><tr><th>response</th><th class=\"number\">{}</th>"
      "<th class=\"number\">observed ± sd</th><th class=\"number\">deviation</th><th>verdict</th>"
      "</tr></thead><tbody>\n",
      results.simulated ? "simulated" : "predicted");
  for (const ResponseResult& response : responses) html += FitRow(response);
  return html + "</tbody></table>\n";
}

std::string FitCard(const StudyResults& results) {
  const std::vector<ResponseResult> targets = TargetResponses(results);
  std::string html = "<section class=\"card fit\"><h3>Fit at the best point</h3>\n" +
                     ResponsesTable(results, targets);
  if (targets.empty()) html += "<p class=\"muted\">There is no response to compare yet.</p>\n";
  const EvaluationResult* best = BestEvaluation(results);
  if (best != nullptr && best->chi2) {
    html += fmt::format("<p class=\"muted small\">χ² = {} over {}.</p>\n",
                        H(NumberText(*best->chi2, 3)),
                        CountText(static_cast<int>(best->responses.size()), "response"));
  }
  return html + "</section>\n";
}

std::string ConfirmationRow(const ResponseResult& other, const ResponseResult& own) {
  const BackendDifference difference = CompareBackends(other, own);
  std::string off = "none";
  if (difference.value) {
    off = (*difference.value > 0 ? "+" : "") + Value(*difference.value, other.unit, 2);
    if (difference.sd) {
      off += fmt::format("<br><span class=\"small muted\">± {}</span>",
                         Value(*difference.sd, other.unit, 2));
    }
  }
  const Fit fit = JudgeFit(other);
  const std::string verdict = !other.simulated ? "<span class=\"tag bad\">no value</span>"
                              : fit.within     ? "<span class=\"tag good\">as observed</span>"
                                               : "<span class=\"tag bad\">off</span>";
  const std::size_t dot = other.name.rfind('.');
  return fmt::format(
      "<tr><td><strong>{}</strong><br><span class=\"small muted\">{}</span></td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">{}<br><span class=\"small muted\">± {}</span></td><td>{}</td></tr>\n",
      H(ReadableName(other.name)), H(ReadableName(other.name.substr(0, dot))), SimulatedCell(other),
      SimulatedCell(own), off, Value(other.observed, other.unit), Value(other.sd, other.unit, 2),
      verdict);
}

std::string ApproximationRow(const ResponseResult& exact, const ResponseResult& approximated) {
  const BackendDifference difference = CompareBackends(approximated, exact);
  std::string off = "none";
  if (difference.value) {
    off = (*difference.value > 0 ? "+" : "") + Value(*difference.value, exact.unit, 2);
    if (difference.sd) {
      off += fmt::format("<br><span class=\"small muted\">± {}</span>",
                         Value(*difference.sd, exact.unit, 2));
    }
  }
  return fmt::format(
      "<tr><td><strong>{}</strong><br><span class=\"small muted\">{}</span></td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">{}</td></tr>\n",
      H(ReadableName(exact.name)), H(ReadableName(exact.name.substr(0, exact.name.rfind('.')))),
      SimulatedCell(approximated), SimulatedCell(exact), off, Value(exact.sd, exact.unit, 2));
}

// What the contact law is not, and what that changes.
std::string ApproximationCard(const StudyResults& results) {
  if (results.approximations.empty()) return "";
  std::string html =
      "<section class=\"card wide approximation\"><h3>Approximation: the contact law as simulated "
      "is not the one that the parameters are of</h3>\n";
  for (const ApproximationStatement& approximation : results.approximations) {
    html += fmt::format("<p><strong>{}: {}.</strong> {}</p>\n", H(approximation.part),
                        H(approximation.name), H(approximation.text));
  }
  if (!results.approximation_effect) {
    return html +
           "<p class=\"muted\">What it changes has not been measured at the best point yet.</p>"
           "</section>\n";
  }
  const ApproximationEffect& effect = *results.approximation_effect;
  html +=
      "<table>\n<thead><tr><th>response at the best point</th><th class=\"number\">with the "
      "approximation</th><th class=\"number\">without</th><th class=\"number\">difference</th>"
      "<th class=\"number\">sd of the observation</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < effect.exact.size(); ++i) {
    html += ApproximationRow(effect.exact[i], effect.approximated[i]);
  }
  html += fmt::format(
      "</tbody></table>\n<p class=\"muted small\">Both with {}, version {}, from the same "
      "particles "
      "at the start; the difference's standard deviation is from the scatter between particle "
      "seeds.</p>\n",
      H(effect.backend), H(effect.version));
  for (const ExperimentFailure& failure : effect.failures) {
    html += fmt::format("<p>{} without the approximation: {}, {}.</p>\n",
                        H(ReadableName(failure.experiment)), H(ReadableName(failure.reason)),
                        H(failure.message));
  }
  return html + "</section>\n";
}

// The best point on other backends.
std::string ConfirmationCard(const StudyResults& results) {
  const EvaluationResult* best = BestEvaluation(results);
  if (best == nullptr || results.confirmations.empty()) return "";
  std::string html =
      "<section class=\"card wide confirmations\"><h3>Confirmation: the best point on other "
      "backends</h3>\n";
  bool compared = false;
  for (const ConfirmationResult& confirmation : results.confirmations) {
    html +=
        fmt::format("<p><strong>{}</strong></p>\n", H(ConfirmationHeadline(results, confirmation)));
    const bool known =
        std::any_of(confirmation.responses.begin(), confirmation.responses.end(),
                    [](const ResponseResult& response) { return response.simulated.has_value(); });
    if (!known) continue;
    compared = true;
    html += fmt::format(
        "<table>\n<thead><tr><th>response</th><th class=\"number\">{}</th><th class=\"number\">{}"
        "</th><th class=\"number\">difference</th><th class=\"number\">observed ± sd</th>"
        "<th>verdict on {}</th></tr></thead><tbody>\n",
        H(confirmation.backend), H(results.backend), H(confirmation.backend));
    for (std::size_t i = 0; i < confirmation.responses.size() && i < best->responses.size(); ++i) {
      html += ConfirmationRow(confirmation.responses[i], best->responses[i]);
    }
    html += "</tbody></table>\n";
    if (confirmation.chi2) {
      html += fmt::format("<p class=\"muted small\">χ² = {} on {}.</p>\n",
                          H(NumberText(*confirmation.chi2, 3)), H(confirmation.backend));
    }
  }
  if (compared) {
    html +=
        "<p class=\"muted small\">Same programs, hence the same particles at the start. The "
        "difference's standard deviation is from the scatter between particle seeds on both "
        "sides.</p>\n";
  }
  return html + "</section>\n";
}

// The best point where it was not fitted.
std::string TransferCard(const StudyResults& results) {
  if (results.transfer.experiments.empty()) return "";
  std::string html = fmt::format(
      "<section class=\"card wide transfer\"><h3>Transfer: the best point on what was not "
      "fitted</h3>\n<p><strong>{}</strong></p>\n",
      H(TransferHeadline(results)));
  html += ResponsesTable(results, results.transfer.responses) + "<ul>\n";
  for (const std::string& statement : TransferStatements(results)) {
    html += fmt::format("<li>{}</li>\n", H(statement));
  }
  return html + "</ul></section>\n";
}

// "2 failed (1 timeout, 1 crashed)", "1 partly failed (1 shear: timeout)".
std::string FailuresText(const StudyResults& results) {
  if (results.failed + results.partial == 0) return "none failed";
  std::map<std::string, int> whole;
  std::map<std::string, int> partly;
  const auto add = [&](const EvaluationResult& evaluation) {
    if (evaluation.outcome == kPartial) {
      for (const ExperimentFailure& failure : evaluation.failures) {
        ++partly[ReadableName(failure.experiment) + ": " + ReadableName(failure.reason)];
      }
    } else if (evaluation.outcome != "ok") {
      ++whole[ReadableName(evaluation.outcome)];
    }
  };
  std::for_each(results.history.begin(), results.history.end(), add);
  std::for_each(results.lower_fidelity.begin(), results.lower_fidelity.end(), add);
  const auto describe = [](int count, const char* what, const std::map<std::string, int>& reasons) {
    std::vector<std::string> list;
    for (const auto& [reason, times] : reasons) list.push_back(fmt::format("{} {}", times, reason));
    return fmt::format("<strong>{} {}</strong>{}", count, what,
                       list.empty() ? "" : " (" + H(JoinNames(list)) + ")");
  };
  std::string text;
  if (results.partial > 0) text = describe(results.partial, "partly failed", partly);
  if (results.failed > 0) {
    text += (text.empty() ? "" : ", ") + describe(results.failed, "failed", whole);
  }
  return text;
}

std::string CostText(const StudyResults& results) {
  std::string text = H(DurationText(results.wall_seconds)) + " wall";
  if (results.simulated) {
    text += fmt::format(", {} inside the simulator, {} at a time",
                        H(DurationText(results.simulation_seconds)), results.parallel);
  }
  if (results.simulated && results.wall_seconds > 0) {
    text += fmt::format("; overhead {}, {} % of the wall time",
                        H(DurationText(results.overhead_seconds)),
                        H(NumberText(100 * results.overhead_seconds / results.wall_seconds, 2)));
  }
  return text + ".";
}

std::string BackendText(const StudyResults& results) {
  std::string text = fmt::format("<strong>{}</strong>", H(results.backend));
  if (!results.backend_version.empty()) text += ", version " + H(results.backend_version);
  if (!results.simulated) return text + ", <strong>no simulation</strong>";
  if (!results.fidelity.empty()) text += ", fidelity " + H(FidelityText(results));
  if (results.replicates > 1) text += fmt::format(", {} particle seeds", results.replicates);
  return text;
}

std::string HowCard(const StudyResults& results) {
  int runs = 0;
  int failed_runs = 0;
  const auto count = [&](const std::vector<RunResult>& more) {
    for (const RunResult& run : more) {
      if (run.reason == "unsupported") continue;  // nothing was simulated
      ++runs;
      if (run.reason != "ok") ++failed_runs;
    }
  };
  for (const EvaluationResult& evaluation : results.history) count(evaluation.runs);
  for (const EvaluationResult& evaluation : results.lower_fidelity) count(evaluation.runs);
  for (const ConfirmationResult& confirmation : results.confirmations) count(confirmation.runs);
  if (results.approximation_effect) count(results.approximation_effect->runs);
  count(results.transfer.runs);
  std::string evaluations = fmt::format("<strong>{}</strong>: {} ok, {}", results.total, results.ok,
                                        FailuresText(results));
  if (const std::string lower = LowerFidelityText(results); !lower.empty()) {
    evaluations += "; " + H(lower);
  }
  if (results.cached > 0)
    evaluations += fmt::format("; {} answered from the ledger", results.cached);
  std::string html = "<section class=\"card how\"><h3>How it was found</h3>\n<dl>\n";
  html += Entry("Backend", BackendText(results));
  html += Entry("Evaluations", evaluations);
  if (results.simulated) {
    html += Entry(
        "Simulations",
        fmt::format("{} runs, {}", runs,
                    failed_runs == 0 ? std::string("none failed")
                                     : fmt::format("<strong>{} failed</strong>", failed_runs)));
  }
  html += Entry("Search", H(results.optimizer));
  html += Entry("Scaling", H(results.scaling));
  html += Entry("Time", CostText(results));
  return html + "</dl></section>\n";
}

std::string CaveatsCard(const StudyResults& results) {
  // The banner and the verdict say these already.
  const std::string headline = Conclude(results).headline;
  std::string items;
  bool notice = !results.simulated;
  for (const std::string& caveat : Caveats(results)) {
    if (notice || caveat == headline) {
      notice = false;
      continue;
    }
    items += fmt::format("<li>{}</li>\n", H(caveat));
  }
  return fmt::format("<section class=\"card caveats\"><h3>Before you use it</h3>\n{}</section>\n",
                     items.empty() ? "<p>Nothing to warn of.</p>\n" : "<ul>" + items + "</ul>\n");
}

std::string GroupRow(const GroupComparison& group) {
  const auto number = [](const std::optional<double>& value) {
    return value ? H(NumberText(*value, 3)) : std::string("—");
  };
  const std::string& verdict = ToString(group.verdict);
  std::string remark = group.remark;
  if (!remark.empty() && remark.back() != '.') remark += '.';
  const std::string limit =
      group.source.empty()
          ? ""
          : fmt::format(" title=\"{} {}: {}\"", group.numerical ? "up to" : "factor",
                        H(NumberText(group.tolerance, 3)), H(group.source));
  return fmt::format(
      "<tr><td><strong>{}</strong></td><td>{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td><span class=\"tag {}\"{}>{}</span></td><td>{}</td></tr>\n",
      SymbolHtml(group.symbol), H(group.meaning), number(group.experiment),
      number(group.simulation), number(group.ratio), verdict, limit, verdict, H(remark));
}

}  // namespace

std::string BannerSection(const StudyResults& results) {
  const std::string notice = NoSimulationNotice(results);
  if (notice.empty()) return "";
  return fmt::format("<p class=\"banner\" role=\"alert\">{}{}</p>",
                     static_cast<char>(notice[0] - 'a' + 'A'), H(notice.substr(1)));
}

std::string SummarySection(const StudyResults& results) {
  static constexpr const char* kClasses[] = {"fits", "rehearsal", "misses", "nothing"};
  const Conclusion conclusion = Conclude(results);
  return fmt::format(
             "<div class=\"verdict {}\"><strong>{}</strong><span>{}</span></div>\n"
             "<div class=\"cards\">\n",
             kClasses[static_cast<int>(conclusion.kind)], H(conclusion.headline),
             H(conclusion.detail)) +
         ParametersCard(results) + FitCard(results) + ApproximationCard(results) +
         ConfirmationCard(results) + TransferCard(results) + HowCard(results) +
         CaveatsCard(results) + "</div>\n";
}

std::string FigureElement(const Figure& figure) {
  const bool wide = figure.key == "parallel" || figure.spec.is_null();
  return fmt::format(
      "<figure class=\"{}\" data-figure=\"{}\"{}{}><h3>{}</h3>{}<figcaption>{}</figcaption>"
      "</figure>\n",
      wide ? "wide" : "half", H(figure.key),
      figure.pair >= 0 ? fmt::format(" data-pair=\"{}\"", figure.pair) : "",
      figure.pair > 0 ? " hidden" : "", H(figure.title),
      figure.spec.is_null() ? "" : "<div class=\"plot\"></div>", H(figure.caption));
}

std::string FiguresSection(const std::vector<Figure>& figures,
                           const std::vector<std::string>& pairs) {
  std::string html = "<section><h2>Figures</h2>\n<div class=\"figures\">\n";
  bool offered = pairs.size() < 2;
  for (const Figure& figure : figures) {
    if (figure.pair >= 0 && !offered) {
      html += "<p class=\"choice\"><label>Plane of the parameters <select id=\"pair\">";
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        html += fmt::format("<option value=\"{}\">{}</option>", i, H(pairs[i]));
      }
      html += "</select></label></p>\n";
      offered = true;
    }
    html += FigureElement(figure);
  }
  return html +
         "</div>\n<noscript><p>The figures are drawn by JavaScript, which is switched "
         "off.</p></noscript></section>\n";
}

std::string ScalingSection(const StudyResults& results) {
  std::string html = fmt::format(
      "<section><h2>Similarity of experiment and simulation</h2>\n<p>Scaling mode "
      "<strong>{}</strong>{}{}</p>\n",
      H(results.scaling), results.scaling_description.empty() ? "" : ": ",
      H(results.scaling_description));
  for (const ScalingTable& table : results.scaling_tables) {
    html += fmt::format(
        "<h3>{}, with the best point's parameters</h3>\n<div class=\"scroll\"><table>\n"
        "<thead><tr><th>Π group</th><th>meaning</th><th class=\"number\">experiment</th>"
        "<th class=\"number\">simulation</th><th class=\"number\">ratio</th><th>verdict</th>"
        "<th>what that means</th></tr></thead><tbody>\n",
        H(table.experiment));
    for (const GroupComparison& group : table.groups) html += GroupRow(group);
    html += "</tbody></table></div>\n";
  }
  if (results.scaling_tables.empty()) html += "<p class=\"muted\">No Π table is known.</p>\n";
  const std::vector<std::string> cohesion = CohesionStatements(results);
  if (!cohesion.empty()) {
    html += "<h3>What the simulation's cohesion says of the powder</h3>\n<ul>\n";
    for (const std::string& sentence : cohesion) {
      html += fmt::format("<li>{}</li>\n", H(sentence));
    }
    html += "</ul>\n";
  }
  return html + fmt::format(
                    "<p class=\"muted small\">ok: within the group's tolerance, or harmless; "
                    "violated: beyond a factor {}; warn: in between; unknown: one side is not "
                    "known. Groups of the simulation alone have limits instead.</p></section>\n",
                    kViolationFactor);
}

std::string ProvenanceSection(const StudyResults& results) {
  std::string html = "<section><h2>Provenance</h2>\n<dl>\n";
  html += Entry("powdercal", H(results.program_version));
  html += Entry("Backend", BackendText(results));
  html += Entry("Study", H(results.study));
  html +=
      Entry("Fingerprint", fmt::format("<span class=\"hash\">{}</span>", H(results.fingerprint)));
  html += Entry("Seed of the study", fmt::format("{}", results.seed));
  html += Entry("Optimizer", H(results.optimizer) +
                                 (results.optimizer_description.empty() ? "" : ": ") +
                                 H(results.optimizer_description));
  html += Entry("Contact law", H(results.law));
  for (const ApproximationStatement& one : results.approximations) {
    html += Entry("Approximation of " + one.part, H(one.name));
  }
  if (results.law_as_run != results.law) {
    html += Entry("Contact law as run", H(results.law_as_run));
  }
  for (const ConfirmationResult& confirmation : results.confirmations) {
    if (confirmation.law.empty()) continue;  // nothing was simulated
    html += Entry("Confirmed with",
                  fmt::format("<strong>{}</strong>, version {}; {}", H(confirmation.backend),
                              H(confirmation.version), H(confirmation.law)));
  }
  html += Entry("State", H(results.state));
  std::vector<ResponseResult> compared = TargetResponses(results);
  compared.insert(compared.end(), results.transfer.responses.begin(),
                  results.transfer.responses.end());
  for (const ResponseResult& response : compared) {
    if (!response.source.empty()) {
      html += Entry("Source of " + ReadableName(response.name), H(response.source));
    }
  }
  html += Entry("Time", CostText(results));
  html += "</dl>\n";
  if (!results.study_yaml.empty()) {
    html += fmt::format(
        "<details><summary>The study, with every default written out</summary>\n<pre>{}</pre>"
        "</details>\n",
        H(results.study_yaml));
  }
  return html + "</section>\n";
}

}  // namespace powdercal
