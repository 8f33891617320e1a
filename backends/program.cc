#include "backends/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/portable_math.h"
#include "core/random.h"

namespace powdercal {
namespace {

// A normal variable z limited to [a, b].
class TruncatedNormal {
 public:
  TruncatedNormal(double a, double b)
      : flipped_(a > 0),
        low_(PortableNormalCdf(flipped_ ? -b : a)),
        high_(PortableNormalCdf(flipped_ ? -a : b)) {}

  // Probability of [a, b]. Both ends are taken in the lower tail where possible: 1 - Phi loses
  // digits.
  double Probability() const { return high_ - low_; }

  double Quantile(double p) const {
    const double level = low_ + (flipped_ ? 1 - p : p) * Probability();
    const double z = NormalQuantile(std::clamp(level, 1e-300, 1 - 0x1p-53));
    return flipped_ ? -z : z;
  }

 private:
  bool flipped_;
  double low_;
  double high_;
};

double Standardised(double value, double mean, double deviation) {
  return (value - mean) / deviation;
}

// Mean and standard deviation of ln d for a lognormal d with the given mean and standard deviation.
struct LogMoments {
  explicit LogMoments(const SizeDistribution& sizes) {
    const double ratio = sizes.standard_deviation / sizes.mean;
    const double variance = PortableLog(1 + ratio * ratio);
    deviation = std::sqrt(variance);
    mean = PortableLog(sizes.mean) - 0.5 * variance;
  }
  double mean;
  double deviation;
};

// The limits of the truncated variable as standard normal ones.
struct Limits {
  explicit Limits(const SizeDistribution& sizes) {
    if (sizes.kind == SizeDistribution::Kind::normal) {
      a = Standardised(sizes.min, sizes.mean, sizes.standard_deviation);
      b = Standardised(sizes.max, sizes.mean, sizes.standard_deviation);
    } else {
      const LogMoments log(sizes);
      a = Standardised(PortableLog(sizes.min), log.mean, log.deviation);
      b = Standardised(PortableLog(sizes.max), log.mean, log.deviation);
    }
  }
  double a;
  double b;
};

// Raw moments of the truncated normal by the recursion of its standardised moments,
// E z^n = (n - 1) E z^(n-2) + (a^(n-1) phi(a) - b^(n-1) phi(b))/P (Burkardt 2014, eq. 10).
double NormalMoment(const SizeDistribution& sizes, int power) {
  const Limits limits(sizes);
  const double probability = TruncatedNormal(limits.a, limits.b).Probability();
  const double at_a = PortableNormalDensity(limits.a) / probability;
  const double at_b = PortableNormalDensity(limits.b) / probability;
  const double z1 = at_a - at_b;
  const double z2 = 1 + limits.a * at_a - limits.b * at_b;
  const double z3 = 2 * z1 + limits.a * limits.a * at_a - limits.b * limits.b * at_b;
  const double m = sizes.mean;
  const double s = sizes.standard_deviation;
  if (power == 1) return m + s * z1;
  if (power == 2) return m * m + 2 * m * s * z1 + s * s * z2;
  return m * m * m + 3 * m * m * s * z1 + 3 * m * s * s * z2 + s * s * s * z3;
}

// E d^n = exp(n mu + n² s²/2) P(a - n s, b - n s)/P(a, b), mu and s being those of ln d.
double LognormalMoment(const SizeDistribution& sizes, int power) {
  const Limits limits(sizes);
  const LogMoments log(sizes);
  const double shift = power * log.deviation;
  return PortableExp(power * log.mean + 0.5 * shift * shift) *
         TruncatedNormal(limits.a - shift, limits.b - shift).Probability() /
         TruncatedNormal(limits.a, limits.b).Probability();
}

template <typename E>
const std::string& NameOf(std::span<const std::string> names, E value) {
  return names[static_cast<std::size_t>(value)];
}

}  // namespace

std::span<const std::string> FidelityNames() {
  static const std::vector<std::string> names = {"quick", "standard", "paper"};
  return names;
}

const std::string& ToString(Fidelity fidelity) { return NameOf(FidelityNames(), fidelity); }

std::span<const std::string> SizeDistributionNames() {
  static const std::vector<std::string> names = {"monodisperse", "normal", "lognormal"};
  return names;
}

std::span<const std::string> NormalLawNames() {
  static const std::vector<std::string> names = {"hertz", "linear"};
  return names;
}

std::span<const std::string> TangentialLawNames() {
  static const std::vector<std::string> names = {"history", "no_history"};
  return names;
}

std::span<const std::string> ShearUpdateNames() {
  static const std::vector<std::string> names = {"displacement", "incremental"};
  return names;
}

std::span<const std::string> CohesionNames() {
  static const std::vector<std::string> names = {"none", "sjkr2", "dmt"};
  return names;
}

std::span<const std::string> RollingNames() {
  static const std::vector<std::string> names = {"none", "cdt", "epsd2"};
  return names;
}

std::span<const std::string> EdgeControlNames() {
  static const std::vector<std::string> names = {"strain_rate", "stress"};
  return names;
}

const std::string& StageName(const Stage& stage) {
  static const std::vector<std::string> names = {"insert", "settle", "servo",   "hold",  "advance",
                                                 "deform", "save",   "restore", "remove"};
  static_assert(std::variant_size_v<Stage> == 9);
  return names[stage.index()];
}

const std::string& MomentName(const Stage& stage) {
  if (const auto* advance = std::get_if<Advance>(&stage)) return advance->name;
  if (const auto* deform = std::get_if<Deform>(&stage)) return deform->name;
  return StageName(stage);
}

std::string ContactLaw::ToString() const {
  std::string text = NameOf(NormalLawNames(), normal);
  text += " + " + NameOf(TangentialLawNames(), tangential);
  if (tangential == Tangential::history) {
    text += fmt::format(" ({})", NameOf(ShearUpdateNames(), shear_update));
  }
  if (cohesion != Cohesion::none) text += " + " + NameOf(CohesionNames(), cohesion);
  if (rolling != Rolling::none) {
    text +=
        " + " + NameOf(RollingNames(), rolling) + (torsion ? " with torsion" : " without torsion");
  }
  text += limit_force ? ", limit_force on" : ", limit_force off";
  return text + (tangential_reduce ? ", tangential_reduce on" : "");
}

std::string SizeDistribution::ExplainInvalid() const {
  if (!(mean > 0) || !std::isfinite(mean)) return fmt::format("mean {} m is not positive", mean);
  if (kind == Kind::monodisperse) return "";
  if (!(standard_deviation > 0) || !std::isfinite(standard_deviation)) {
    return fmt::format("standard deviation {} m is not positive", standard_deviation);
  }
  if (!(min > 0)) return fmt::format("smallest diameter {} m is not positive", min);
  if (!(max > min) || !std::isfinite(max)) {
    return fmt::format("largest diameter {} m is not above the smallest, {} m", max, min);
  }
  const Limits limits(*this);
  if (TruncatedNormal(limits.a, limits.b).Probability() < 1e-6) {
    return fmt::format("less than a millionth of the distribution lies between {} m and {} m", min,
                       max);
  }
  return "";
}

double SizeDistribution::Quantile(double p) const {
  assert(p >= 0 && p <= 1);
  if (kind == Kind::monodisperse) return mean;
  if (p <= 0) return min;
  if (p >= 1) return max;
  const Limits limits(*this);
  const double z = TruncatedNormal(limits.a, limits.b).Quantile(p);
  if (kind == Kind::normal) return std::clamp(mean + standard_deviation * z, min, max);
  const LogMoments log(*this);
  return std::clamp(PortableExp(log.mean + log.deviation * z), min, max);
}

double SizeDistribution::Moment(int power) const {
  assert(power >= 1 && power <= 3);
  switch (kind) {
    case Kind::normal:
      return NormalMoment(*this, power);
    case Kind::lognormal:
      return LognormalMoment(*this, power);
    case Kind::monodisperse:
      break;
  }
  return power == 1 ? mean : power == 2 ? mean * mean : mean * mean * mean;
}

double RayleighTime(double radius, double density, double young_modulus, double poisson_ratio) {
  const double shear_modulus = young_modulus / (2 * (1 + poisson_ratio));
  return std::numbers::pi * radius * std::sqrt(density / shear_modulus) /
         (0.1631 * poisson_ratio + 0.8766);
}

}  // namespace powdercal
