#pragma once

#include <string>

#include "studies/results.h"

namespace powdercal {

/// The report: one HTML file that opens offline, in which everything, plotting libraries included,
/// is inline. Its first screen says what was calibrated, how well it fits, with what, and what to
/// beware of; figures, evaluations, Pi groups and provenance follow.
std::string HtmlReport(const StudyResults& results);

}  // namespace powdercal
