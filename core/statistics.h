#pragma once

#include <span>
#include <vector>

namespace powdercal {

/// NaN without values.
double Mean(std::span<const double> values);
/// Sum of (value − mean)²; 0 for fewer than two values.
double SquaresAboutMean(std::span<const double> values);
/// Of the values themselves, divisor n − 1; 0 for fewer than two.
double StandardDeviation(std::span<const double> values);
/// Of an even number of values the mean of the middle two; NaN without values.
double Median(std::vector<double> values);

}  // namespace powdercal
