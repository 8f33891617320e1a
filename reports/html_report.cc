#include "reports/html_report.h"

#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "reports/assets.h"
#include "reports/html_page.h"
#include "reports/html_sections.h"
#include "reports/plots.h"
#include "reports/text.h"

namespace powdercal {
namespace {

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
                       {"libraries", ScriptLibraries()},
                       {"js", std::string(Asset("report.js"))}});
}

}  // namespace powdercal
