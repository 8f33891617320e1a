#pragma once

#include <span>
#include <vector>

#include "verification/contact_cases.h"
#include "verification/finding.h"
#include "verification/runs.h"

namespace powdercal::verification {

/// Rung 1: every pair of backends in every case of the law, frame by frame at the same times.
///
/// For each pair and case the law is taken in a form that both know (forms.h): first the
/// subject's own, then the other `shear_update` or `torsion`. Which one it was is in the finding.
/// Where a case looks the same in several forms, each backend may have its own.
std::vector<Finding> VerifyContacts(const Subject& subject, std::span<const Contender> contenders,
                                    const RunOptions& options);

/// Differences of two traces of a case, the largest over all frames and spheres: of positions over
/// the sphere's radius, of velocities over the largest speed that occurs, of a centre or of a
/// surface (radius times spin), of spins times radius over the same. The verdicts are those against
/// `tolerance` [-]. An outcome that is not ok: the traces have not the same frames.
std::vector<Quantity> CompareTrajectories(const Trace& a, const Trace& b, double tolerance,
                                          Outcome* outcome);

}  // namespace powdercal::verification
