#pragma once

#include <string>
#include <vector>

#include "reports/plots.h"
#include "studies/results.h"

namespace powdercal {

// The parts of the HTML report, each a piece of markup in which all text is escaped.

/// The banner where no simulation was run, else "".
std::string BannerSection(const StudyResults& results);
/// The first screen: verdict, parameters, fit, how it was found, caveats.
std::string SummarySection(const StudyResults& results);
/// Places for the figures; report.js draws into them.
std::string FiguresSection(const std::vector<Figure>& figures,
                           const std::vector<std::string>& pairs);
/// One figure's place.
std::string FigureElement(const Figure& figure);
/// What several objectives have to do with each other: statement, `figures`, table of the front;
/// "" with fewer than two objectives or without a complete evaluation.
std::string ParetoSection(const StudyResults& results, const std::vector<Figure>& figures);
/// The table of evaluations, and the simulations behind them.
std::string EvaluationsSection(const StudyResults& results);
/// The Pi groups of each experiment.
std::string ScalingSection(const StudyResults& results);
/// Versions, laws, seeds, cost, the resolved study.
std::string ProvenanceSection(const StudyResults& results);

}  // namespace powdercal
