#pragma once

#include <string>
#include <vector>

#include "studies/study.h"

namespace powdercal::cli {

struct CollapseCommand {
  std::vector<double> kappas;            ///< floors of rigid_limit; empty: the defaults
  std::vector<std::string> experiments;  ///< names; empty: all of the study
  std::vector<double> parameters;        ///< [SI]
  int replicates = 3;
  std::string folder;  ///< for collapse.json and collapse.html; "": none
  bool json = false;
};

/// Simulates the study's experiments under several scalings and prints which groups the responses
/// follow; returns an ExitStatus.
int RunCollapse(const Study& study, const CollapseCommand& command);

}  // namespace powdercal::cli
