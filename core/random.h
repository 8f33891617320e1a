#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace powdercal {

/// A seeded stream of random numbers that is the same on every platform: the generator is
/// xoshiro256** (Blackman & Vigna 2021, doi:10.1145/3460772), seeded by SplitMix64, and the
/// distributions use IEEE arithmetic only, no library mathematics. Passed in, never global.
class RandomStream {
 public:
  using result_type = std::uint64_t;

  explicit RandomStream(std::uint64_t seed);

  /// An independent stream named by a label or an index: the same parent seed and the same name
  /// give the same stream, however much was drawn from the parent.
  RandomStream Split(std::string_view label) const;
  RandomStream Split(std::uint64_t index) const;

  std::uint64_t seed() const { return seed_; }

  std::uint64_t Bits();                        ///< 64 random bits
  double Uniform();                            ///< in [0, 1), 53 bits
  double Uniform(double lower, double upper);  ///< in [lower, upper)
  std::uint64_t Below(std::uint64_t count);    ///< in {0, …, count − 1}, unbiased; count ≥ 1
  double Normal();                             ///< standard normal, by inversion

  template <typename T>
  void Shuffle(std::span<T> items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[Below(i)]);
  }

  // UniformRandomBitGenerator, for use with libraries where exact reproduction does not matter.
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return ~result_type{0}; }
  result_type operator()() { return Bits(); }

 private:
  std::uint64_t seed_;
  std::array<std::uint64_t, 4> state_;
};

/// Natural logarithm from IEEE additions, multiplications and divisions alone (relative error below
/// 4e-16), so that it rounds alike on every platform. Requires x > 0 and finite.
double PortableLog(double x);

/// Quantile of the standard normal distribution (Wichura 1988, algorithm AS 241, PPND16; relative
/// error about 1e-16), on PortableLog. Requires 0 < p < 1.
double NormalQuantile(double p);

}  // namespace powdercal
