#include "reports/html_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "reports/assets.h"
#include "tests/reports/sample_studies.h"

namespace powdercal {
namespace {

using testing::HasSubstr;
using testing::Not;

int Count(std::string_view text, std::string_view part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

// The document without what stands between <script…> and </script>, <style> and </style>.
std::string Markup(std::string html) {
  for (const std::string name : {"script", "style"}) {
    std::size_t at = 0;
    while ((at = html.find("<" + name, at)) != std::string::npos) {
      const std::size_t content = html.find('>', at) + 1;
      const std::size_t end = html.find("</" + name + ">", content);
      if (end == std::string::npos) return html;
      html.erase(content, end - content);
      at = content;
    }
  }
  return html;
}

nlohmann::json Specs(const std::string& html) {
  const std::string open = "<script type=\"application/json\" id=\"figures\">";
  const std::size_t begin = html.find(open) + open.size();
  return nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin));
}

// Names of elements that were opened and not closed, or the other way round.
std::vector<std::string> Unbalanced(const std::string& markup) {
  const std::vector<std::string> empty = {"meta", "link", "br", "!doctype"};
  std::vector<std::string> open;
  std::vector<std::string> wrong;
  for (auto at = markup.find('<'); at != std::string::npos; at = markup.find('<', at + 1)) {
    const bool closing = markup[at + 1] == '/';
    const std::size_t start = at + (closing ? 2 : 1);
    const std::string name = markup.substr(start, markup.find_first_of(" >\n", start) - start);
    if (std::count(empty.begin(), empty.end(), name) > 0) continue;
    if (!closing) {
      open.push_back(name);
    } else if (!open.empty() && open.back() == name) {
      open.pop_back();
    } else {
      wrong.push_back("/" + name);
    }
  }
  wrong.insert(wrong.end(), open.begin(), open.end());
  return wrong;
}

TEST(HtmlReportTest, FirstScreenSaysWhatHowWellWithWhat) {
  const std::string html = HtmlReport(QuickstartSample());
  const std::string first = Markup(html).substr(0, Markup(html).find("<h2>Figures"));
  for (const char* part :
       {"Calibration of Hastelloy X", "Calibrated: the void ratio", "55400 J/m³", "0.66", "0.7789",
        "0.783", "within ±", "<strong>liggghts</strong>, version 3.8.0",
        "<strong>14</strong>: 12 ok", "2 failed", "28 runs", "1 timeout", "0.75 % of the wall time",
        "2 parameters were fitted to 1 response"}) {
    EXPECT_THAT(first, HasSubstr(part));
  }
  EXPECT_THAT(html, Not(HasSubstr("class=\"banner\"")));
}

TEST(HtmlReportTest, TablesFollow) {
  const std::string markup = Markup(HtmlReport(QuickstartSample()));
  EXPECT_EQ(Count(markup, "<tr class=\"best\">"), 1);
  EXPECT_THAT(markup, HasSubstr("no result within 600 s; the process group was killed"));
  EXPECT_THAT(markup, HasSubstr("<span class=\"tag violated\">violated</span>"));
  EXPECT_THAT(markup, HasSubstr("4000 times too soft"));
  EXPECT_THAT(markup, HasSubstr("gran model hertz tangential history"));
  EXPECT_THAT(markup, HasSubstr("9f36d4c137efa251"));
  EXPECT_THAT(markup, HasSubstr("<pre>study: quickstart"));
  EXPECT_THAT(markup, HasSubstr("Redistribution and use in source and binary forms"));
}

TEST(HtmlReportTest, GroupsHaveColoursTolerancesAndTheWayBack) {
  StudyResults results = QuickstartSample();
  ASSERT_FALSE(results.scaling_tables.empty());
  ScalingTable& table = results.scaling_tables[0];
  table.groups[0].tolerance = 1.5;
  table.groups[0].source = "measured <there>";
  table.cohesion = PowderCohesion{.experiment = "consolidation",
                                  .surface_energy = 13.4e-3,
                                  .kept = "F_c/(sigma d^2)",
                                  .young_modulus = 5e6,
                                  .cohesion_energy_density = 47500,
                                  .stated = 1e-4};
  const std::string html = HtmlReport(results);
  EXPECT_THAT(html, HasSubstr("<span class=\"tag violated\" title=\"factor 1.5: measured "
                              "&lt;there&gt;\">violated</span>"));
  for (const char* verdict : {"ok", "warn", "unknown"}) {
    EXPECT_THAT(html, HasSubstr("<span class=\"tag " + std::string(verdict) + "\">"));
    EXPECT_THAT(html, HasSubstr(".tag." + std::string(verdict)));
  }
  EXPECT_THAT(html, HasSubstr("stands for a powder with a surface energy of 13 mJ/m2"));
}

TEST(HtmlReportTest, BannerWhereNothingWasSimulated) {
  const std::string html = HtmlReport(TableSample());
  EXPECT_THAT(html,
              HasSubstr("<p class=\"banner\" role=\"alert\">No simulation was run: the table"));
  EXPECT_THAT(html, Not(HasSubstr("Calibrated: ")));
  EXPECT_THAT(html, Not(HasSubstr("Calibrated parameters")));
}

TEST(HtmlReportTest, EveryFigureHasItsPlaceAndItsSpecification) {
  for (const StudyResults& results :
       {QuickstartSample(), TableSample(), FailedSample(), JointSample(), LineSample(),
        ParetoSample(), ParetoSample(3)}) {
    const std::string html = HtmlReport(results);
    const nlohmann::json specs = Specs(html);
    EXPECT_EQ(static_cast<int>(specs.size()), Count(html, "<div class=\"plot\"></div>"));
    for (const auto& [key, spec] : specs.items()) {
      EXPECT_EQ(Count(html, "data-figure=\"" + key + "\""), 1) << key;
    }
    EXPECT_TRUE(specs.contains("convergence"));
  }
  EXPECT_THAT(HtmlReport(JointSample()), HasSubstr("<select id=\"pair\"><option value=\"0\">"));
}

TEST(HtmlReportTest, SeveralObjectivesHaveASectionOfTheirOwn) {
  const StudyResults results = ParetoSample();
  const std::string markup = Markup(HtmlReport(results));
  const std::size_t begin = markup.find("<h2>What fits together</h2>");
  ASSERT_NE(begin, std::string::npos);
  const std::string section = markup.substr(begin, markup.find("<h2>", begin + 1) - begin);
  EXPECT_THAT(section, HasSubstr("Where shear fits best (evaluation"));
  EXPECT_THAT(section, HasSubstr("misfit<br><span class=\"small muted\">shear</span>"));
  EXPECT_EQ(Count(section, "<tr><td") + Count(section, "<tr class=\"best\"><td"),
            static_cast<int>(results.pareto.size()));
  EXPECT_EQ(Count(section, "★ best"), 1);
  EXPECT_THAT(section, HasSubstr("data-figure=\"pareto\""));
  EXPECT_THAT(HtmlReport(JointSample()), Not(HasSubstr("What fits together")));
}

TEST(HtmlReportTest, ElementsAreBalanced) {
  for (const StudyResults& results :
       {QuickstartSample(), TableSample(), FailedSample(), JointSample(), LineSample(),
        ParetoSample(), ParetoSample(3), StudyResults{}}) {
    EXPECT_THAT(Unbalanced(Markup(HtmlReport(results))), testing::IsEmpty());
  }
}

TEST(HtmlReportTest, LoadsNothing) {
  const std::string html = HtmlReport(QuickstartSample());
  const std::string markup = Markup(html);
  for (const char* part : {" src=", "@import", "srcset=", "<iframe", "<img"}) {
    EXPECT_EQ(Count(markup, part), 0) << part;
  }
  EXPECT_EQ(Count(markup, "href="), Count(markup, "href=\"data:,\""));
  EXPECT_EQ(Count(Asset("report.css"), "url("), 0);
  EXPECT_EQ(Count(Asset("report.css"), "@import"), 0);
  EXPECT_EQ(Count(Asset("report.js"), "http"), 0);
  EXPECT_EQ(Count(html, "sourceMappingURL"), 0);
  EXPECT_EQ(Specs(html).dump().find("http"), std::string::npos);
}

TEST(HtmlReportTest, NamesCannotBecomeMarkup) {
  const std::string evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";
  StudyResults results = ParetoSample();
  results.objectives = {evil, evil};
  for (std::string* text :
       {&results.study, &results.description, &results.powder, &results.fingerprint,
        &results.program_version, &results.optimizer, &results.optimizer_description,
        &results.backend, &results.backend_version, &results.fidelity, &results.law,
        &results.law_as_run, &results.scaling, &results.scaling_description, &results.study_yaml,
        &results.stop_reason, &results.parameters[0].symbol, &results.parameters[1].unit}) {
    *text = evil;
  }
  results.state = evil;
  results.warnings = {evil};
  for (EvaluationResult& evaluation : results.history) {
    evaluation.origin = evil;
    evaluation.message = evil;
    if (evaluation.outcome != "ok") evaluation.outcome = evil;
    for (ResponseResult& response : evaluation.responses) {
      response.name = "x." + evil;
      response.unit = evil;
      response.source = evil;
    }
    for (RunResult& run : evaluation.runs) {
      run.experiment = run.program_hash = run.message = evil;
      if (run.reason != "ok") run.reason = evil;
      run.diagnostics[evil] = 1;
    }
  }
  results.scaling_tables = {
      {.experiment = evil, .groups = {{.symbol = evil, .meaning = evil, .remark = evil}}}};
  const std::string html = HtmlReport(results);
  EXPECT_EQ(Count(html, "<script>alert"), 0);
  EXPECT_EQ(Count(Markup(html), "<img"), 0);
  EXPECT_EQ(Count(html, "<script"), Count(html, "</script>"));
  EXPECT_EQ(Count(html, "<script"), Count(HtmlReport(ParetoSample()), "<script"));
  EXPECT_FALSE(Specs(html).empty());
}

TEST(HtmlReportTest, TemplateKeysInTextStayAsTheyAre) {
  StudyResults results = QuickstartSample();
  results.description = "{{js}}";
  EXPECT_THAT(HtmlReport(results), HasSubstr("<p class=\"subtitle\">Study quickstart: {{js}}</p>"));
}

TEST(HtmlReportTest, LibrariesCannotEndTheirScript) {
  for (const char* name : {"vega.min.js", "vega-lite.min.js", "vega-embed.min.js", "report.js"}) {
    const std::string_view script = Asset(name);
    EXPECT_GT(script.size(), 1000u) << name;
    EXPECT_EQ(Count(script, "</script"), 0) << name;
    EXPECT_EQ(Count(script, "<!--"), 0) << name;
  }
}

TEST(HtmlReportTest, TransferredResponsesStandApart) {
  const std::string markup = Markup(HtmlReport(TransferSample()));
  const auto card = markup.find("<section class=\"card wide transfer\">");
  ASSERT_NE(card, std::string::npos);
  const std::string transfer = markup.substr(card, markup.find("</section>", card) - card);
  for (const char* part : {"was not fitted", "coverage", "3.8 standard deviations too low",
                           "not observed", "Repose gave no value"}) {
    EXPECT_THAT(transfer, HasSubstr(part));
  }
  EXPECT_THAT(transfer, Not(HasSubstr("void ratio")));
  const std::string fit = markup.substr(markup.find("card fit"), card - markup.find("card fit"));
  EXPECT_THAT(fit, Not(HasSubstr("coverage")));
  EXPECT_THAT(markup, HasSubstr("photograph, &lt;3 trials&gt;"));
  EXPECT_THAT(Unbalanced(markup), testing::IsEmpty());
  EXPECT_TRUE(Specs(HtmlReport(TransferSample())).contains("transfer"));
  EXPECT_THAT(Markup(HtmlReport(JointSample())), Not(HasSubstr("card wide transfer")));
}

TEST(HtmlReportTest, ConfirmationsHaveACardOfTheirOwn) {
  const std::string markup = Markup(HtmlReport(ConfirmationSample()));
  const auto card = markup.find("<section class=\"card wide confirmations\">");
  ASSERT_NE(card, std::string::npos);
  const std::string text = markup.substr(card, markup.find("</section>", card) - card);
  for (const char* part : {"embedded 1 does not confirm the best point", "verdict on embedded",
                           "+0.04", "no value", "it has no &lt;shear&gt; cell",
                           "absent could not confirm the best point", "χ² = 17.3 on embedded"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, Not(HasSubstr("verdict on absent")));
  EXPECT_THAT(markup, HasSubstr("hertz + history, &lt;as run&gt;"));
  EXPECT_THAT(Unbalanced(markup), testing::IsEmpty());
  EXPECT_THAT(Markup(HtmlReport(JointSample())), Not(HasSubstr("card wide confirmations")));
}

TEST(HtmlReportTest, ApproximationsHaveACardOfTheirOwn) {
  StudyResults results = ApproximationSample();
  const std::string markup = Markup(HtmlReport(results));
  const auto card = markup.find("<section class=\"card wide approximation\">");
  ASSERT_NE(card, std::string::npos);
  const std::string text = markup.substr(card, markup.find("</section>", card) - card);
  for (const char* part : {"dmt_pull_off", "SJKR2 is &lt;approximated&gt; by DMT.", "+0.02",
                           "shear without the approximation: timeout", "Both with embedded"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(Unbalanced(markup), testing::IsEmpty());
  results.approximation_effect.reset();
  EXPECT_THAT(Markup(HtmlReport(results)), HasSubstr("has not been measured"));
  EXPECT_THAT(Markup(HtmlReport(JointSample())), Not(HasSubstr("card wide approximation")));
}

TEST(HtmlReportTest, PartialFailuresSayWhichExperiment) {
  const std::string markup = Markup(HtmlReport(TransferSample()));
  EXPECT_THAT(markup, HasSubstr("1 partly failed</strong> (1 shear: not quasi static)"));
  EXPECT_THAT(markup, HasSubstr("✕ in part"));
  EXPECT_THAT(markup, HasSubstr("shear: no steady state"));
  EXPECT_THAT(markup, HasSubstr("quick; shear: standard"));
}

TEST(HtmlReportTest, LowerFidelitiesStandApart) {
  const StudyResults sample = SeveralFidelitiesSample();
  const std::string markup = Markup(HtmlReport(sample));
  EXPECT_THAT(markup, HasSubstr("5 of them at a lower fidelity (quick): learnt from, not ranked"));
  EXPECT_THAT(markup, HasSubstr("<summary>5 evaluations at a lower fidelity"));
  const std::size_t table = markup.find("id=\"lower_fidelity\"");
  ASSERT_NE(table, std::string::npos);
  EXPECT_THAT(markup.substr(table), HasSubstr("<td>quick</td>"));
  EXPECT_THAT(markup.substr(0, table), Not(HasSubstr("<td>quick</td>")));
  EXPECT_THAT(markup, HasSubstr("timeout")) << "failures of either are counted";
  EXPECT_THAT(Markup(HtmlReport(QuickstartSample())), Not(HasSubstr("lower fidelity")));
}

TEST(HtmlReportTest, CategoriesAreNames) {
  const std::string html = HtmlReport(CategoricalSample());
  EXPECT_THAT(html, HasSubstr("rolling model</td><td class=\"number value\">epsd2</td>"
                              "<td class=\"number small\">cdt and epsd2</td>"));
  EXPECT_THAT(html, HasSubstr("<td>cdt</td>"));
}

}  // namespace
}  // namespace powdercal
