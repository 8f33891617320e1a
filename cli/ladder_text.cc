#include "cli/ladder_text.h"

#include <fmt/format.h>

#include <map>
#include <vector>

#include "cli/text.h"
#include "reports/text.h"

namespace powdercal::cli {
namespace {

using namespace verification;

std::string Pair(const Finding& finding) { return finding.a + ", " + finding.b; }

std::string ContactTable(const LadderReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"case", "level", "backends", "position", "velocity", "spin", "tolerance", "verdict"}};
  for (const Finding& finding : report.findings) {
    if (finding.rung != Rung::contact || finding.verdict == Verdict::unsupported) continue;
    std::vector<std::string> row = {finding.name, finding.level, Pair(finding)};
    for (std::size_t i = 0; i < 3; ++i) {
      row.push_back(i < finding.quantities.size()
                        ? fmt::format("{:.1e}", finding.quantities[i].difference)
                        : "-");
    }
    row.push_back(
        finding.quantities.empty() ? "-" : fmt::format("{:.0e}", finding.quantities[0].tolerance));
    row.push_back(ToString(finding.verdict));
    rows.push_back(std::move(row));
  }
  return rows.size() > 1 ? AlignedTable(rows) : "";
}

std::string Number(double value) { return fmt::format("{:.4g}", value); }

std::string SeedTable(const LadderReport& report, Rung rung) {
  std::vector<std::vector<std::string>> rows = {
      {"quantity", "a, b", "a", "b", "n", "b - a",
       fmt::format("{:.0f} % interval", 100 * (1 - 2 * report.options.level)), "margin",
       "verdict"}};
  for (const Finding& finding : report.findings) {
    if (finding.rung != rung || finding.verdict == Verdict::unsupported) continue;
    for (const Quantity& q : finding.quantities) {
      if (!q.seeds) continue;
      const SeedStatistics& s = *q.seeds;
      rows.push_back({finding.name + "." + q.name, Pair(finding),
                      fmt::format("{} ± {:.2g}", Number(s.mean_a), s.sd_a),
                      fmt::format("{} ± {:.2g}", Number(s.mean_b), s.sd_b), std::to_string(s.n),
                      fmt::format("{:+.2g}", q.difference),
                      fmt::format("[{:+.2g}, {:+.2g}]", s.lower, s.upper),
                      fmt::format("{:.2g}", q.tolerance),
                      q.counts ? ToString(q.verdict) : ToString(q.verdict) + " (does not count)"});
    }
  }
  return rows.size() > 1 ? AlignedTable(rows) : "";
}

std::string CalibrationTable(const LadderReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"backends", "quantity", "value", "bound", "verdict"}};
  for (const Finding& finding : report.findings) {
    if (finding.rung != Rung::calibration || finding.verdict == Verdict::unsupported) continue;
    for (const Quantity& q : finding.quantities) {
      rows.push_back({Pair(finding), q.name, fmt::format("{:.3g}", q.difference),
                      q.counts ? fmt::format("{:.3g}", q.tolerance) : "-",
                      q.counts ? ToString(q.verdict) : "-"});
    }
  }
  return rows.size() > 1 ? AlignedTable(rows) : "";
}

// Reasons and notes, each once, with the cases that it holds for.
std::string Remarks(const LadderReport& report, Rung rung) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<std::string>> cases;
  const auto add = [&](const std::string& text, const std::string& name) {
    std::vector<std::string>& names = cases[text];
    if (names.empty()) order.push_back(text);
    names.push_back(name);
  };
  for (const Finding& finding : report.findings) {
    if (finding.rung != rung) continue;
    if (!finding.reason.empty()) {
      add(fmt::format("{}, {}: {}", Pair(finding), ToString(finding.verdict), finding.reason),
          finding.name);
    }
    if (!finding.note.empty())
      add(fmt::format("{}: {}", Pair(finding), finding.note), finding.name);
    for (const Quantity& quantity : finding.quantities) {
      if (quantity.note.empty()) continue;
      add(fmt::format("{}: {}", Pair(finding), quantity.note),
          fmt::format("{}.{}", finding.name, quantity.name));
    }
  }
  std::string text;
  for (const std::string& remark : order) {
    text += fmt::format("  {} ({})\n", remark, JoinNames(cases[remark]));
  }
  return text;
}

}  // namespace

std::string LadderText(const LadderReport& report) {
  std::string text =
      fmt::format("{}: {}\nlaw: {}\n", report.subject, report.description, report.law);
  for (const ContenderInfo& contender : report.contenders) {
    text +=
        contender.why_not.empty()
            ? fmt::format("backend: {} {}{}\n", contender.name, contender.version,
                          contender.description.empty() ? "" : " (" + contender.description + ")")
            : fmt::format("backend: {}, not available: {}\n", contender.name, contender.why_not);
  }
  for (const Rung rung : report.options.rungs) {
    text += fmt::format("\nrung {}, {}\n", static_cast<int>(rung) + 1, ToString(rung));
    const std::string table = rung == Rung::contact       ? ContactTable(report)
                              : rung == Rung::calibration ? CalibrationTable(report)
                                                          : SeedTable(report, rung);
    const std::string remarks = Remarks(report, rung);
    text += table;
    if (!table.empty() && !remarks.empty()) text += "\n";
    text += remarks;
  }
  if (!report.failures.empty()) text += "\nfailed runs\n";
  for (const FailedRun& run : report.failures) {
    text += fmt::format("  {} in {}: {}, {}\n", run.name, run.backend, run.reason, run.message);
  }
  text += "\n";
  for (std::size_t i = 0; i < VerdictNames().size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", report.Count(static_cast<Verdict>(i)),
                        VerdictNames()[i]);
  }
  const bool nothing =
      report.Count(Verdict::unsupported) == static_cast<int>(report.findings.size());
  const char* result = report.interrupted ? "interrupted"
                       : nothing          ? "nothing could be compared"
                       : report.passed()  ? "no supported rung differs"
                                          : "the backends are not shown to be equivalent";
  return text + fmt::format(": {} ({})\n", result, DurationText(report.wall_seconds));
}

}  // namespace powdercal::cli
