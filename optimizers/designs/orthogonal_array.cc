#include "optimizers/designs/orthogonal_array.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>
#include <vector>

namespace powdercal {
namespace {

constexpr std::array<int, 10> kLevels = {2, 3, 4, 5, 7, 8, 9, 11, 13, 16};

// GF(p^n). An element is the number whose digits in base p are the coefficients of a polynomial;
// products are taken modulo an irreducible one.
class Field {
 public:
  // remainder: the coefficients, from the lowest, of x^n modulo that polynomial; n of them.
  Field(int prime, std::vector<int> remainder)
      : prime_(prime), remainder_(std::move(remainder)), degree_(remainder_.size()) {}

  int Add(int a, int b) const {
    std::vector<int> sum = Digits(a);
    const std::vector<int> other = Digits(b);
    for (std::size_t k = 0; k < degree_; ++k) sum[k] += other[k];
    return Number(sum);
  }

  int Multiply(int a, int b) const {
    std::vector<int> power = Digits(a);  // a x^k
    std::vector<int> product(degree_, 0);
    for (const int digit : Digits(b)) {
      for (std::size_t k = 0; k < degree_; ++k) product[k] += digit * power[k];
      power = TimesX(power);
    }
    return Number(product);
  }

 private:
  std::vector<int> Digits(int element) const {
    std::vector<int> digits;
    for (std::size_t k = 0; k < degree_; ++k, element /= prime_) digits.push_back(element % prime_);
    return digits;
  }
  int Number(const std::vector<int>& digits) const {
    int number = 0;
    for (std::size_t k = degree_; k-- > 0;) number = number * prime_ + digits[k] % prime_;
    return number;
  }
  std::vector<int> TimesX(const std::vector<int>& digits) const {
    const int top = digits.back();
    std::vector<int> result(degree_);
    for (std::size_t k = 0; k < degree_; ++k) {
      result[k] = ((k > 0 ? digits[k - 1] : 0) + top * remainder_[k]) % prime_;
    }
    return result;
  }

  int prime_;
  std::vector<int> remainder_;
  std::size_t degree_;
};

Field FieldOf(int levels) {
  switch (levels) {
    case 4:
      return {2, {1, 1}};  // x² = x + 1
    case 8:
      return {2, {1, 1, 0}};  // x³ = x + 1
    case 9:
      return {3, {2, 0}};  // x² = −1
    case 16:
      return {2, {1, 1, 0, 0}};  // x⁴ = x + 1
    default:
      return {levels, {0}};  // a prime
  }
}

}  // namespace

std::span<const int> OrthogonalArrayLevels() { return kLevels; }

Eigen::MatrixXi OrthogonalArray(int levels) {
  if (std::find(kLevels.begin(), kLevels.end(), levels) == kLevels.end()) {
    throw std::invalid_argument("OrthogonalArray: no array of so many levels");
  }
  const Field field = FieldOf(levels);
  Eigen::MatrixXi array(levels * levels, levels + 1);
  for (int i = 0; i < levels; ++i) {
    for (int j = 0; j < levels; ++j) {
      const Eigen::Index row = i * levels + j;
      array(row, 0) = i;
      for (int c = 0; c < levels; ++c) array(row, c + 1) = field.Add(field.Multiply(c, i), j);
    }
  }
  return array;
}

}  // namespace powdercal
