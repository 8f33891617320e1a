#include "reports/comparison_page.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/quantity.h"
#include "reports/assets.h"
#include "reports/comparison_json.h"
#include "reports/html_page.h"
#include "reports/html_sections.h"
#include "reports/results_json.h"
#include "reports/text.h"

namespace powdercal {
namespace {

using namespace comparison;

// χ² as people write it, and `names` as code.
std::string Words(const std::string& text) {
  std::string html;
  bool code = false;
  for (const char c : H(Sentence(text))) {
    if (c != '`') {
      html += c;
      continue;
    }
    html += code ? "</code>" : "<code>";
    code = !code;
  }
  for (std::size_t at = html.find("chi²"); at != std::string::npos; at = html.find("chi²", at)) {
    html.replace(at, std::string_view("chi²").size(), "χ²");
  }
  return html;
}

std::string List(const std::vector<std::string>& sentences) {
  std::string html = "<ul>\n";
  for (const std::string& sentence : sentences) html += "<li>" + Words(sentence) + "</li>\n";
  return html + "</ul>\n";
}

std::string Banner(const Comparison& comparison) {
  switch (comparison.setting.source) {
    case Source::emulator:
      return fmt::format(
          "<div class=\"banner\" role=\"alert\">No simulation was run in these contests: an "
          "emulator "
          "of {} answered.</div>",
          H(comparison.setting.source_text));
    case Source::table:
      return "<div class=\"banner\" role=\"alert\">No simulation was run: the table backend "
             "answered.</div>";
    case Source::simulator:
      break;
  }
  return "";
}

std::string Summary(const Comparison& comparison) {
  const Recommendation words = Recommend(comparison);
  const bool shown =
      std::isfinite(comparison.critical_difference) && comparison.friedman.f_p < kAlpha;
  const char* kind = comparison.standings.empty() ? "nothing" : shown ? "fits" : "rehearsal";
  std::string html = fmt::format(
      "<section class=\"verdict {}\"><strong>{}</strong><span>{} optimizers, {} seeds, {} "
      "evaluations each{}.</span></section>\n",
      kind, Words(words.headline), comparison.standings.size(), comparison.seeds.size(),
      comparison.setting.rules.evaluations,
      comparison.interrupted ? "; interrupted, the same command goes on" : "");
  html += "<div class=\"cards\">\n";
  if (!words.statements.empty()) {
    html += "<section class=\"card wide\"><h3>What was found</h3>\n" + List(words.statements) +
            "</section>\n";
  }
  return html + "<section class=\"card wide\"><h3>What it does not say</h3>\n" +
         List(words.limits) + "</section>\n</div>\n";
}

// A cell that sorts by its number.
std::string Cell(double key, const std::string& text, const std::string& title = "") {
  return fmt::format("<td class=\"number\" data-sort=\"{}\"{}>{}</td>",
                     std::isfinite(key) ? fmt::format("{:.9g}", key) : "",
                     title.empty() ? "" : fmt::format(" title=\"{}\"", H(title)), text);
}

std::string Number(double value, int digits = 3) {
  return std::isfinite(value) ? H(NumberText(value, digits)) : "none";
}

std::string Cell(const Quartiles& q, int digits = 3) {
  return Cell(q.median, fmt::format("{}<br><span class=\"muted small\">{} – {}</span>",
                                    Number(q.median, digits), Number(q.lower, digits),
                                    Number(q.upper, digits)));
}

std::string Row(const Comparison& comparison, const Standing& standing) {
  const bool first = &standing == &comparison.standings.front();
  std::string html =
      fmt::format("<tr{}><td title=\"{}\">{}</td>", first ? " class=\"best\"" : "",
                  H(standing.contestant.description + "\n" + standing.contestant.options),
                  H(standing.contestant.label));
  html += Cell(standing.mean_rank, Number(standing.mean_rank));
  html += Cell(standing.final_value);
  const auto seeds = static_cast<double>(comparison.seeds.size());
  html += Cell(
      standing.to_level.median,
      fmt::format("{}<br><span class=\"muted small\">{:.0f} % of seeds</span>",
                  std::isfinite(standing.to_level.median) ? Number(standing.to_level.median) : "—",
                  100 * standing.reached / seeds));
  if (comparison.setting.source != Source::table) {
    html += Cell(standing.within_core_seconds);
    html += Cell(standing.mean_rank_by_cost, Number(standing.mean_rank_by_cost));
    html += Cell(standing.core_seconds.median, Number(standing.core_seconds.median));
  }
  for (const Quartiles& one : standing.hold_out) html += Cell(one);
  html += Cell(standing.parallel_efficiency.median,
               std::isfinite(standing.parallel_efficiency.median)
                   ? fmt::format("{:.2f}", standing.parallel_efficiency.median)
                   : "—");
  html += Cell(standing.evaluations.median, Number(standing.evaluations.median));
  html += Cell(standing.failed_share, fmt::format("{:.0f} %", 100 * standing.failed_share));
  html += Cell(standing.optimizer_seconds, H(fmt::format("{:.2g} s", standing.optimizer_seconds)));
  return html + "</tr>\n";
}

std::string Standings(const Comparison& comparison) {
  if (comparison.standings.empty()) return "";
  const bool costs = comparison.setting.source != Source::table;
  const std::string measure = comparison.pareto ? "lost hypervolume" : "χ²";
  std::string html = fmt::format(
      "<section id=\"standings\"><h2>The optimizers side by side</h2>\n<p class=\"muted\">Medians "
      "over the seeds; below them quartiles. {} Click a heading to sort.</p>\n"
      "<div class=\"across\"><table class=\"sortable\"><thead><tr><th>optimizer</th>",
      comparison.setting.source == Source::simulator
          ? "χ² is the expected misfit of the reported point, as it was observed."
          : "χ² is that of the point that a study would report, without scatter.");
  const auto head = [&](const std::string& text) {
    html += fmt::format("<th class=\"number\">{}</th>", H(text));
  };
  head("mean rank");
  head(measure + " at the end");
  head(fmt::format("evaluations to {}", NumberText(comparison.level, 3)));
  if (costs) {
    head(fmt::format("{} at {} core-s", measure, NumberText(comparison.core_seconds, 3)));
    head("mean rank there");
    head("core-s spent");
  }
  for (const std::string& fidelity : comparison.hold_out_fidelities) {
    head(fmt::format("χ² held out ({})", fidelity));
  }
  head("parallel efficiency");
  head("evaluations");
  head("failed");
  head("own time each");
  html += "</tr></thead><tbody>\n";
  for (const Standing& standing : comparison.standings) html += Row(comparison, standing);
  return html + "</tbody></table></div></section>\n";
}

std::string Refused(const Comparison& comparison) {
  if (comparison.refused.empty()) return "";
  std::string html =
      "<section id=\"refused\"><h2>Left out</h2>\n<table><thead><tr><th>optimizer</th><th>why it "
      "cannot treat this study</th></tr></thead><tbody>\n";
  for (const Refusal& one : comparison.refused) {
    html += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", H(one.label), Words(one.reason));
  }
  return html + "</tbody></table></section>\n";
}

std::string EmulatorSection(const Comparison& comparison) {
  const Setting& setting = comparison.setting;
  if (setting.source != Source::emulator) return "";
  std::string html = fmt::format(
      "<section id=\"emulator\"><h2>The emulator</h2>\n<p>Fitted to {} simulations at {} parameter "
      "points of {}, {} of them failed: a Gaussian process for each response, with scatter between "
      "particle seeds, for the time of a simulation, and a probability of failure.</p>\n"
      "<table><thead><tr><th>response</th><th class=\"number\">points</th>"
      "<th class=\"number\">leave-one-out R²</th><th class=\"number\">residuals over the "
      "observation's sd</th><th class=\"number\">scatter between seeds (sd)</th><th>scatter "
      "from</th>"
      "</tr></thead><tbody>\n",
      setting.emulator_runs, setting.emulator_points, H(setting.source_text),
      setting.emulator_failed_runs);
  for (const Emulator::Quality& one : setting.emulator) {
    const bool poor = one.leave_one_out_r2 < Emulator::kPoorR2;
    html += fmt::format(
        "<tr><td>{}</td><td class=\"number\">{}</td><td class=\"number\"><span class=\"tag "
        "{}\">{:.2f}</span></td><td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td>"
        "</tr>\n",
        H(one.response), one.points, poor ? "warn" : "good", one.leave_one_out_r2,
        Number(one.share_of_sd, 2), H(ValueText(one.seed_sd, one.unit, 2)),
        one.from_replicates ? "replicates" : "residuals");
  }
  return html + "</tbody></table></section>\n";
}

std::string Provenance(const Comparison& comparison) {
  const Setting& setting = comparison.setting;
  const Rules& rules = setting.rules;
  std::string html = "<section><h2>The rules, and the command</h2>\n<dl>\n";
  const auto entry = [&](const char* term, const std::string& text) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", term, H(text));
  };
  entry("study", setting.study);
  entry("answers from", setting.source_text);
  entry("evaluations", fmt::format("{}, failed ones included", rules.evaluations));
  if (std::isfinite(rules.core_seconds)) {
    entry("core-seconds", NumberText(rules.core_seconds, 4));
  }
  entry("one evaluation",
        fmt::format("{} of {}", CountText(rules.replicates, "particle seed"),
                    CountText(static_cast<int>(rules.experiments.size()), "experiment")));
  entry("simulations at a time",
        fmt::format("{}, in virtual time: each lasts as long as its run did", rules.slots));
  entry("initial design", setting.initial_design + ", the same for all that begin with one");
  entry("seeds", fmt::format("{} of {} ended by all", comparison.seeds.size(), setting.seeds));
  html += "</dl>\n<pre>";
  for (const std::string& line : setting.command) html += H(line) + "\n";
  return html + "</pre></section>\n";
}

}  // namespace

std::string ComparisonPage(const Comparison& comparison) {
  const std::vector<Figure> figures = ComparisonFigures(comparison);
  nlohmann::json specs = nlohmann::json::object();
  for (const Figure& figure : figures) {
    if (!figure.spec.is_null()) specs[figure.key] = figure.spec;
  }
  const Setting& setting = comparison.setting;
  const std::string subtitle =
      setting.description.empty() ? setting.study : setting.study + ": " + setting.description;
  return FillTemplate(Asset("comparison.html"),
                      {{"version", H(setting.program_version)},
                       {"title", H("Optimizers compared – " + setting.study)},
                       {"heading", "Optimizers compared"},
                       {"subtitle", H(subtitle)},
                       {"css", std::string(Asset("report.css"))},
                       {"banner", Banner(comparison)},
                       {"summary", Summary(comparison)},
                       {"standings", Standings(comparison)},
                       {"figures", figures.empty() ? "" : FiguresSection(figures, {})},
                       {"refused", Refused(comparison)},
                       {"emulator", EmulatorSection(comparison)},
                       {"provenance", Provenance(comparison)},
                       {"licences", H(Asset("licences.txt"))},
                       {"data", ScriptJson(specs)},
                       {"libraries", ScriptLibraries()},
                       {"js", std::string(Asset("report.js"))}});
}

void WriteComparison(const Comparison& comparison, const std::filesystem::path& folder) {
  const std::string json = JsonText(ComparisonToJson(comparison));
  const std::string page = ComparisonPage(comparison);
  WriteFileAtomically(folder / "comparison.json", json);
  WriteFileAtomically(folder / "comparison.html", page);
}

}  // namespace powdercal
