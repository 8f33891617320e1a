#include "verification/equivalence.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <stdexcept>

#include "core/statistics.h"

namespace powdercal::verification {
namespace {

constexpr int kMostSeeds = 10'000;

double HalfWidth(double sd, int n, double level) {
  if (sd <= 0) return 0;
  const boost::math::students_t student(n - 1);
  return boost::math::quantile(boost::math::complement(student, level)) * sd / std::sqrt(n);
}

Verdict VerdictOf(double mean, double half_width, double margin) {
  if (std::abs(mean) + half_width < margin) return Verdict::equivalent;
  if (std::abs(mean) - half_width > margin) return Verdict::different;
  return Verdict::undecided;
}

// P(T > t) of the test whose statistic is (distance from the margin)/(standard error).
double TailBeyond(double distance, double standard_error, int n) {
  if (standard_error <= 0) return distance > 0 ? 0 : 1;
  const boost::math::students_t student(n - 1);
  return boost::math::cdf(boost::math::complement(student, distance / standard_error));
}

}  // namespace

MeanAndSd Summarise(std::span<const double> values) {
  if (values.empty()) return {};
  return {Mean(values), StandardDeviation(values)};
}

Verdict TestEquivalence(std::span<const SeedPair> pairs, const EquivalenceTest& test,
                        SeedStatistics* statistics) {
  if (!(test.margin > 0)) throw std::invalid_argument("TestEquivalence: margin must be positive");
  std::vector<double> a, b, differences;
  for (const SeedPair& pair : pairs) {
    a.push_back(pair.a);
    b.push_back(pair.b);
    differences.push_back(pair.b - pair.a);
  }
  const MeanAndSd first = Summarise(a);
  const MeanAndSd second = Summarise(b);
  const MeanAndSd d = Summarise(differences);
  const int n = static_cast<int>(pairs.size());
  *statistics = {.n = n,
                 .mean_a = first.mean,
                 .mean_b = second.mean,
                 .sd_a = first.sd,
                 .sd_b = second.sd,
                 .sd_difference = d.sd,
                 .lower = d.mean,
                 .upper = d.mean};
  if (n < 2) {
    statistics->seeds_needed = 2;
    return Verdict::undecided;
  }
  const double half_width = HalfWidth(d.sd, n, test.level);
  const double standard_error = d.sd / std::sqrt(n);
  statistics->lower = d.mean - half_width;
  statistics->upper = d.mean + half_width;
  statistics->p = std::max(TailBeyond(test.margin + d.mean, standard_error, n),
                           TailBeyond(test.margin - d.mean, standard_error, n));
  const Verdict verdict = VerdictOf(d.mean, half_width, test.margin);
  if (verdict != Verdict::undecided) return verdict;
  for (int more = n + 1; more <= kMostSeeds && statistics->seeds_needed == 0; ++more) {
    const Verdict then = VerdictOf(d.mean, HalfWidth(d.sd, more, test.level), test.margin);
    if (then != Verdict::undecided) statistics->seeds_needed = more;
  }
  return verdict;
}

}  // namespace powdercal::verification
