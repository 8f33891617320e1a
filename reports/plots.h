#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "studies/results.h"

namespace powdercal {

/// A plot of the report: a Vega-Lite specification with its data, or the reason why there is none.
struct Figure {
  std::string key;  ///< unique in a report: "convergence", "surface-0-1-0"
  std::string title;
  std::string caption;  ///< plain text
  int pair = -1;        ///< of parameters, where the reader chooses one; −1: always shown
  nlohmann::json spec;  ///< null where nothing can be drawn; the caption says why
};

/// chi² of every evaluation, and the lowest so far.
Figure ConvergenceFigure(const StudyResults& results);

/// Each response over the parameters, as far as the evaluations tell: a line for one parameter, a
/// colour map for each pair of two or three, for the first pair of more (others at the best point).
std::vector<Figure> SurfaceFigures(const StudyResults& results);
/// Titles of the pairs that SurfaceFigures numbers; empty with fewer than two parameters.
std::vector<std::string> ParameterPairs(const StudyResults& results);

/// With more than three parameters: every evaluation as a line across them; else empty.
std::vector<Figure> ParallelFigures(const StudyResults& results);

/// With two objectives: the misfit of every evaluation in the one over that in the other, the front
/// marked; with more: a line for each evaluation across the objectives. Else empty, and so without
/// a complete evaluation.
std::vector<Figure> ParetoFigures(const StudyResults& results);

/// With two targets or more: simulated against observed at the best point, one figure for each
/// unit.
std::vector<Figure> FitFigures(const StudyResults& results);

/// With two or more observed responses of experiments that were not fitted: their deviations.
std::vector<Figure> TransferFigures(const StudyResults& results);

}  // namespace powdercal
