#include "reports/write.h"

#include <string>

#include "core/files.h"
#include "reports/html_report.h"
#include "reports/material_card.h"
#include "reports/results_json.h"

namespace powdercal {

void WriteReports(const StudyResults& results, const std::filesystem::path& run_folder) {
  const std::string json = JsonText(ResultsToJson(results));
  const std::string card = MaterialCard(results);
  const std::string report = HtmlReport(results);
  WriteFileAtomically(run_folder / "results.json", json);
  WriteFileAtomically(run_folder / "material_card.yaml", card);
  WriteFileAtomically(run_folder / "report.html", report);
}

}  // namespace powdercal
