#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "optimizers/optimizer.h"

namespace powdercal {

/// A problem of nonlinear regression of the Statistical Reference Datasets (National Institute of
/// Standards and Technology, Information Technology Laboratory): data, two starting points and
/// certified results.
struct NistProblem {
  struct Parameter {
    double start[2];
    double certified;
  };
  /// Of the parameters and the predictors.
  using Model = double (*)(const double* b, const double* x);

  std::string name;
  Model model;
  double residual_squares;  ///< certified
  double residual_sd;       ///< certified
  std::vector<Parameter> parameters;

  /// Predictors and response of each observation (tests/optimizers/nist/NAME.csv).
  struct Row {
    std::array<double, 2> x;
    double y;
  };
  std::vector<Row> Data() const;

  /// NIST's problems have no bounds. This box contains both starts and the certified values. Along
  /// a parameter of one sign it goes from a tenth of the smallest of the three magnitudes to ten
  /// times the largest where these are more than twenty apart (on a log scale if positive);
  /// elsewhere the hull of the three is extended on both sides by its own width or half the largest
  /// magnitude, if that is more, without a change of sign.
  SearchSpace Space() const;

  /// One target for each observation, its sd the certified residual one (at least 1e-9 of the
  /// largest, which the generated data of Lanczos1 need).
  Objectives Targets() const;
};

/// All 27.
std::span<const NistProblem> NistProblems();

}  // namespace powdercal
