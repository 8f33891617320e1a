#include "reports/html_report.h"

#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "reports/assets.h"
#include "reports/html_sections.h"
#include "reports/html_template.h"
#include "reports/plots.h"
#include "reports/text.h"

namespace powdercal {
namespace {

// Source maps would be looked for beside the report.
std::string_view WithoutSourceMap(std::string_view script) {
  const std::size_t comment = script.rfind("//# sourceMappingURL=");
  return comment == std::string_view::npos ? script : script.substr(0, comment);
}

std::string Libraries() {
  std::string scripts;
  for (const char* name : {"vega.min.js", "vega-lite.min.js", "vega-embed.min.js"}) {
    scripts.append("<script>").append(WithoutSourceMap(Asset(name))).append("</script>\n");
  }
  return scripts;
}

// JSON that no HTML parser can take for markup.
std::string ScriptJson(const nlohmann::json& value) {
  const std::string json = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";
    } else if (c == '>') {
      safe += "\\u003e";
    } else if (c == '&') {
      safe += "\\u0026";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::vector<Figure> AllFigures(const StudyResults& results) {
  std::vector<Figure> figures = {ConvergenceFigure(results)};
  for (const auto make : {FitFigures, TransferFigures, SurfaceFigures, ParallelFigures}) {
    std::vector<Figure> more = make(results);
    figures.insert(figures.end(), std::make_move_iterator(more.begin()),
                   std::make_move_iterator(more.end()));
  }
  return figures;
}

}  // namespace

std::string HtmlReport(const StudyResults& results) {
  const std::vector<Figure> figures = AllFigures(results);
  const std::vector<Figure> pareto = ParetoFigures(results);
  nlohmann::json specs = nlohmann::json::object();
  for (const std::vector<Figure>* group : {&pareto, &figures}) {
    for (const Figure& figure : *group) {
      if (!figure.spec.is_null()) specs[figure.key] = figure.spec;
    }
  }
  const std::string powder = results.powder.empty() ? results.study : results.powder;
  std::string subtitle = "Study " + results.study;
  if (!results.description.empty()) subtitle += ": " + results.description;
  return FillTemplate(Asset("report.html"),
                      {{"version", EscapeHtml(results.program_version)},
                       {"title", EscapeHtml("Calibration of " + powder + " – " + results.study)},
                       {"heading", EscapeHtml("Calibration of " + powder)},
                       {"subtitle", EscapeHtml(subtitle)},
                       {"css", std::string(Asset("report.css"))},
                       {"banner", BannerSection(results)},
                       {"summary", SummarySection(results)},
                       {"pareto", ParetoSection(results, pareto)},
                       {"figures", FiguresSection(figures, ParameterPairs(results))},
                       {"evaluations", EvaluationsSection(results)},
                       {"scaling", ScalingSection(results)},
                       {"provenance", ProvenanceSection(results)},
                       {"licences", EscapeHtml(Asset("licences.txt"))},
                       {"data", ScriptJson(specs)},
                       {"libraries", Libraries()},
                       {"js", std::string(Asset("report.js"))}});
}

}  // namespace powdercal
