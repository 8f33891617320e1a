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
/// Of an even number of values the upper one of the middle two; NaN without values.
double UpperMedian(std::vector<double> values);
/// Linear between order statistics (Hyndman & Fan 1996, type 7), 0 ≤ p ≤ 1; ∞ where that involves
/// a value that is infinite; NaN without values.
double Quantile(std::vector<double> values, double p);

}  // namespace powdercal
