#pragma once

#include "studies/results.h"

namespace powdercal {

/// Studies made up for the tests of reports/; their figures are of the paper's order.

/// k and μr against one void ratio, 14 evaluations, two of them failed, as of a LIGGGHTS study.
StudyResults QuickstartSample();
/// The same, answered by the table backend.
StudyResults TableSample();
/// QuickstartSample with the law of rolling friction as a third parameter; the best is epsd2.
StudyResults CategoricalSample();
/// QuickstartSample() at `standard`, five of its points at `quick`, one of these failed.
StudyResults SeveralFidelitiesSample();
/// Three evaluations, all of which failed.
StudyResults FailedSample();
/// Three parameters, one of them on a logarithmic scale, and three responses in two units.
StudyResults JointSample();
/// The joint study with shear and consolidation at fidelities of their own; evaluation 7 failed in
/// shear alone; its best point was evaluated on spreading, of which one response is far off, one
/// agrees and one was not observed, and on repose, which failed.
StudyResults TransferSample();
/// The joint study with its best point on three other backends: embedded, which gives all
/// responses, the void ratio much higher; shearless, which has only that; and one that is absent.
StudyResults ConfirmationSample();
/// The joint study with a declared approximation, measured: the void ratio is off, the stresses are
/// not known without it.
StudyResults ApproximationSample();
/// The joint sample with an objective for each experiment, of which shear is off by a constant:
/// what fits one does not fit the other. `objectives` = 3: the second stress is of a third
/// experiment.
StudyResults ParetoSample(int objectives = 2);
/// One parameter, one response.
StudyResults LineSample();

}  // namespace powdercal
