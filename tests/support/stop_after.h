#pragma once

#include <stop_token>
#include <vector>

#include "studies/runner.h"

namespace powdercal {

/// Stops a study, as a signal would, after a number of evaluations.
class StopAfter : public ProgressListener {
 public:
  StopAfter(std::stop_source& stop, int evaluations) : stop_(stop), left_(evaluations) {}
  void OnEvaluation(const LedgerCandidate&, const ReducedResponses&,
                    const std::vector<ExperimentFailure>&, const Progress&) override {
    if (--left_ == 0) stop_.request_stop();
  }

 private:
  std::stop_source& stop_;
  int left_;
};

}  // namespace powdercal
