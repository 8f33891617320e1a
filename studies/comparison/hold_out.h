#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/random.h"
#include "studies/comparison/contest_runner.h"
#include "studies/comparison/oracle.h"
#include "studies/comparison/record.h"

namespace powdercal::comparison {

/// Replicates from this one on are fresh particle seeds: no contest has as many.
inline constexpr int kFirstHoldOut = 1'000'000;

/// The stream that an oracle draws chance from in the contests of one seed.
RandomStream WorldOf(const Study& study, int seed);

/// chi² of the means over these runs; NaN where a target has no value.
double HoldOutChi2(const Objectives& objectives, const std::vector<LedgerRun>& runs);

HoldOut HoldOutOnOracle(const Study& study, const Oracle& oracle, const Eigen::VectorXd& point,
                        int seeds, const RandomStream& world);

/// Puts label, seed, key and time into a record, and why it ended where it broke off.
void Sign(const Task& task, double optimizer_seconds, ContestRecord* record);

/// "quick", or "quick, standard" where experiments differ.
std::string FidelityText(const Study& study);

}  // namespace powdercal::comparison
