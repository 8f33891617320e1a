#include "reports/verification_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "reports/assets.h"
#include "reports/html_page.h"
#include "reports/results_json.h"
#include "reports/text.h"
#include "verification/ladder_json.h"

namespace powdercal {
namespace {

using namespace verification;

const char* TagOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::equivalent:
      return "good";
    case Verdict::different:
    case Verdict::failed:
      return "bad";
    case Verdict::undecided:
      return "off";
    case Verdict::unsupported:
      break;
  }
  return "unknown";
}

std::string Tag(Verdict verdict, const std::string& text = "") {
  return fmt::format("<span class=\"tag {}\">{}</span>", TagOf(verdict),
                     H(text.empty() ? ToString(verdict) : text));
}

std::string PairText(const Finding& finding) { return H(finding.a + " – " + finding.b); }

// The interval of a difference against the margin, which takes the middle half of the picture.
std::string IntervalPicture(const Quantity& quantity) {
  if (!quantity.seeds || !(quantity.tolerance > 0)) return "";
  constexpr double kWidth = 160;
  const auto place = [&](double value) {
    return std::clamp(kWidth / 2 + value / quantity.tolerance * kWidth / 4, 1.0, kWidth - 1);
  };
  const char* colour = quantity.verdict == Verdict::equivalent  ? "#14602f"
                       : quantity.verdict == Verdict::different ? "#97200f"
                                                                : "#a36a00";
  const double lower = place(quantity.seeds->lower);
  const double upper = place(quantity.seeds->upper);
  return fmt::format(
      "<svg width=\"160\" height=\"14\" role=\"img\" aria-label=\"interval against margin\">"
      "<rect x=\"40\" y=\"0\" width=\"80\" height=\"14\" fill=\"#e4f4e8\"/>"
      "<line x1=\"80\" y1=\"0\" x2=\"80\" y2=\"14\" stroke=\"#b5bfc6\"/>"
      "<rect x=\"{:.1f}\" y=\"5\" width=\"{:.1f}\" height=\"4\" fill=\"{}\"/>"
      "<circle cx=\"{:.1f}\" cy=\"7\" r=\"3.5\" fill=\"{}\"/></svg>",
      lower, std::max(1.0, upper - lower), colour, place(quantity.difference), colour);
}

std::string Remark(const Finding& finding) {
  std::string text = finding.reason;
  if (!finding.note.empty()) text += (text.empty() ? "" : "; ") + finding.note;
  for (const Quantity& quantity : finding.quantities) {
    if (!quantity.note.empty())
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", quantity.name, quantity.note);
  }
  return H(text);
}

std::string ContactRows(const LadderReport& report) {
  std::string html =
      "<thead><tr><th>case</th><th>level</th><th>backends</th><th class=\"number\">position</th>"
      "<th class=\"number\">velocity</th><th class=\"number\">spin</th>"
      "<th class=\"number\">tolerance</th><th>verdict</th><th>remark</th></tr></thead><tbody>\n";
  for (const Finding& finding : report.findings) {
    if (finding.rung != Rung::contact) continue;
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td>", H(finding.name), H(finding.level),
                        PairText(finding));
    for (std::size_t i = 0; i < 3; ++i) {
      html += fmt::format("<td class=\"number\">{}</td>",
                          i < finding.quantities.size()
                              ? fmt::format("{:.1e}", finding.quantities[i].difference)
                              : "—");
    }
    html += fmt::format(
        "<td class=\"number\">{}</td><td>{}</td><td class=\"small message\">{}</td></tr>\n",
        finding.quantities.empty() ? "—" : fmt::format("{:.0e}", finding.quantities[0].tolerance),
        Tag(finding.verdict), Remark(finding));
  }
  return html + "</tbody>";
}

std::string Mean(double mean, double sd, const std::string& unit) {
  const DisplayUnit display = DisplayUnitOf(unit);
  return H(fmt::format("{} ± {}", NumberText(mean * display.per_si),
                       NumberText(sd * display.per_si, 2)));
}

std::string SeedRow(const Finding& finding, const Quantity& quantity) {
  const SeedStatistics& s = *quantity.seeds;
  const DisplayUnit unit = DisplayUnitOf(quantity.unit);
  const std::string name = unit.name == "1"
                               ? quantity.name
                               : fmt::format("{} [{}]", quantity.name, PrettyUnit(unit.name));
  return fmt::format(
      "<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">[{}, {}]</td><td>{}</td><td class=\"number\" title=\"{}\">{}</td>"
      "<td class=\"number\">{}</td><td>{}</td></tr>\n",
      H(finding.name + ": " + name), PairText(finding), Mean(s.mean_a, s.sd_a, quantity.unit),
      Mean(s.mean_b, s.sd_b, quantity.unit), s.n, NumberText(quantity.difference * unit.per_si, 2),
      NumberText(s.lower * unit.per_si, 2), NumberText(s.upper * unit.per_si, 2),
      IntervalPicture(quantity), H(quantity.tolerance_reason),
      NumberText(quantity.tolerance * unit.per_si, 2), NumberText(s.p, 2),
      quantity.counts ? Tag(quantity.verdict)
                      : fmt::format("{} <span class=\"muted small\">does not count</span>",
                                    Tag(quantity.verdict)));
}

std::string SeedRows(const LadderReport& report, Rung rung) {
  std::string html = fmt::format(
      "<thead><tr><th>quantity</th><th>backends a – b</th><th class=\"number\">a</th>"
      "<th class=\"number\">b</th><th class=\"number\">seeds</th><th class=\"number\">b − a</th>"
      "<th class=\"number\">{:.0f} % interval</th><th>against the margin</th>"
      "<th class=\"number\">margin</th><th class=\"number\">p</th><th>verdict</th></tr></thead>"
      "<tbody>\n",
      100 * (1 - 2 * report.options.level));
  for (const Finding& finding : report.findings) {
    if (finding.rung != rung) continue;
    for (const Quantity& quantity : finding.quantities) {
      if (quantity.seeds) html += SeedRow(finding, quantity);
    }
    const std::string remark = Remark(finding);
    if (remark.empty() && !finding.quantities.empty()) continue;
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td colspan=\"8\" class=\"small\">{}</td><td>{}</td></tr>\n",
        H(finding.name), PairText(finding), remark, Tag(finding.verdict));
  }
  return html + "</tbody>";
}

std::string CalibrationRows(const LadderReport& report) {
  std::string html =
      "<thead><tr><th>backends</th><th>quantity</th><th class=\"number\">value</th>"
      "<th class=\"number\">bound</th><th>verdict</th></tr></thead><tbody>\n";
  for (const Finding& finding : report.findings) {
    if (finding.rung != Rung::calibration) continue;
    for (const Quantity& quantity : finding.quantities) {
      html += fmt::format(
          "<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\" "
          "title=\"{}\">{}</td><td>{}</td></tr>\n",
          PairText(finding), H(quantity.name), NumberText(quantity.difference, 3),
          H(quantity.tolerance_reason), quantity.counts ? NumberText(quantity.tolerance, 3) : "—",
          quantity.counts ? Tag(quantity.verdict,
                                quantity.verdict == Verdict::equivalent ? "accepts" : "rejects")
                          : "");
    }
    html +=
        fmt::format("<tr><td>{}</td><td colspan=\"3\" class=\"small\">{}</td><td>{}</td></tr>\n",
                    PairText(finding), Remark(finding), Tag(finding.verdict));
  }
  return html + "</tbody>";
}

const char* Explanation(Rung rung) {
  switch (rung) {
    case Rung::contact:
      return "Two spheres, or a sphere and a wall, frame by frame at the same times. Differences "
             "are "
             "the largest over the whole contact: of positions over the radius, of velocities over "
             "the largest speed of a centre or a surface, of spins times radius over the same.";
    case Rung::packing:
      return "1000 spheres from an identical packing, pressed by a lid. Equivalence is shown by "
             "two "
             "one-sided tests (Schuirmann 1987), seed by seed: the interval of the mean difference "
             "has to lie within the margin, the green field.";
    case Rung::experiment:
      return "The study's experiments at the given parameters, with the same tests. The margin of "
             "a "
             "response is the standard deviation of its observation.";
    case Rung::calibration:
      break;
  }
  return "Whether each backend would have accepted the parameters: chi² of the calibrated "
         "responses "
         "against the quantile of the chi-squared distribution.";
}

std::string RungSection(const LadderReport& report, Rung rung) {
  const std::string rows = rung == Rung::contact       ? ContactRows(report)
                           : rung == Rung::calibration ? CalibrationRows(report)
                                                       : SeedRows(report, rung);
  return fmt::format(
      "<section id=\"{}\"><h2>Rung {}: {}</h2>\n<p class=\"muted\">{}</p>\n"
      "<div class=\"scroll\"><table>\n{}</table></div></section>\n",
      ToString(rung), static_cast<int>(rung) + 1, ToString(rung), Explanation(rung), rows);
}

// One cell of the overview: how many cases of each verdict.
std::string Cell(const LadderReport& report, Rung rung, const std::string& a,
                 const std::string& b) {
  std::string html;
  for (std::size_t v = 0; v < VerdictNames().size(); ++v) {
    const auto verdict = static_cast<Verdict>(v);
    const auto count =
        std::count_if(report.findings.begin(), report.findings.end(), [&](const Finding& f) {
          return f.rung == rung && f.a == a && f.b == b && f.verdict == verdict;
        });
    if (count > 0) html += Tag(verdict, fmt::format("{} {}", count, ToString(verdict))) + " ";
  }
  return html;
}

std::string SummarySection(const LadderReport& report) {
  const bool nothing =
      report.Count(Verdict::unsupported) == static_cast<int>(report.findings.size());
  const bool good = report.passed() && !nothing && !report.interrupted;
  const char* headline = report.interrupted ? "Interrupted"
                         : nothing          ? "Nothing could be compared"
                         : report.passed()  ? "No supported rung differs"
                                            : "The backends are not shown to be equivalent";
  std::string html = fmt::format(
      "<section class=\"verdict {}\"><strong>{}</strong><span>{} equivalent, {} different, {} "
      "undecided, {} failed, {} unsupported.</span></section>\n",
      good ? "fits" : "misses", headline, report.Count(Verdict::equivalent),
      report.Count(Verdict::different), report.Count(Verdict::undecided),
      report.Count(Verdict::failed), report.Count(Verdict::unsupported));
  html += "<table><thead><tr><th>backends</th>";
  for (const Rung rung : report.options.rungs) html += fmt::format("<th>{}</th>", ToString(rung));
  html += "</tr></thead><tbody>\n";
  for (std::size_t a = 0; a < report.contenders.size(); ++a) {
    for (std::size_t b = a + 1; b < report.contenders.size(); ++b) {
      const std::string& first = report.contenders[a].name;
      const std::string& second = report.contenders[b].name;
      html += fmt::format("<tr><td>{}</td>", H(first + " – " + second));
      for (const Rung rung : report.options.rungs) {
        html += fmt::format("<td>{}</td>", Cell(report, rung, first, second));
      }
      html += "</tr>\n";
    }
  }
  return html + "</tbody></table>\n";
}

std::string ProvenanceSection(const LadderReport& report) {
  std::string html = "<section><h2>What was run</h2>\n<dl>\n";
  const auto entry = [&](const char* term, const std::string& markup) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", term, markup);
  };
  entry("law", H(report.law));
  for (const ContenderInfo& contender : report.contenders) {
    entry(
        "backend",
        H(contender.why_not.empty()
              ? fmt::format("{} {}{}", contender.name, contender.version,
                            contender.description.empty() ? "" : " (" + contender.description + ")")
              : fmt::format("{}, not available: {}", contender.name, contender.why_not)));
  }
  entry("particle seeds", fmt::format("1 to {}", report.options.seeds));
  entry("level of each one-sided test", NumberText(report.options.level));
  for (const auto& [name, value] : report.options.margins) {
    entry("margin given", H(fmt::format("{} = {:g} (SI)", name, value)));
  }
  for (const auto& [name, value] : report.parameters) {
    entry("parameter", H(fmt::format("{} = {:g} (SI)", name, value)));
  }
  for (const auto& [name, choice] : report.choices) {
    entry("parameter", H(fmt::format("{} = {}", name, choice)));
  }
  if (!report.parameters_source.empty()) entry("parameters from", H(report.parameters_source));
  entry("time", H(DurationText(report.wall_seconds)));
  html += "</dl>\n";
  if (!report.failures.empty()) html += "<h3>Failed runs</h3>\n<ul>\n";
  for (const FailedRun& run : report.failures) {
    html += fmt::format("<li>{}</li>\n",
                        H(fmt::format("{}, {} in {}: {}, {}", ToString(run.rung), run.name,
                                      run.backend, run.reason, run.message)));
  }
  if (!report.failures.empty()) html += "</ul>\n";
  return html + "</section>\n";
}

}  // namespace

std::string VerificationPage(const LadderReport& report) {
  std::vector<std::string> names;
  for (const ContenderInfo& contender : report.contenders) names.push_back(contender.name);
  std::string rungs;
  for (const Rung rung : report.options.rungs) rungs += RungSection(report, rung);
  const std::string heading = "Verification of " + JoinNames(names);
  return FillTemplate(
      Asset("verification.html"),
      {{"version", H(report.program_version)},
       {"title", H(heading + " – " + report.subject)},
       {"heading", H(heading)},
       {"subtitle", H(report.description.empty() ? report.subject
                                                 : report.subject + ": " + report.description)},
       {"css", std::string(Asset("report.css"))},
       {"summary", SummarySection(report)},
       {"rungs", rungs},
       {"provenance", ProvenanceSection(report)}});
}

void WriteVerification(const LadderReport& report, const std::filesystem::path& folder) {
  WriteFileAtomically(folder / "verification.json", JsonText(LadderToJson(report)));
  WriteFileAtomically(folder / "verification.html", VerificationPage(report));
}

}  // namespace powdercal
