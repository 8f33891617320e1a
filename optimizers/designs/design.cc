#include "optimizers/designs/design.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <stdexcept>

#include "core/random.h"
#include "optimizers/designs/orthogonal_array.h"

namespace powdercal {
namespace {

const std::array<std::string, 6> kNames = {
    "corners_and_centre", "grid", "latin_hypercube", "list", "orthogonal_array", "sobol"};
constexpr int kMaxPoints = 100000;
constexpr int kMaxCornerDimension = 10;
constexpr int kLatinHypercubes = 50;

bool HasLevels(const std::string& name) { return name == "grid" || name == "orthogonal_array"; }

int PointCount(const DesignOptions& options, int dimension) {
  return options.points > 0 ? options.points : std::max(5, 2 * (dimension + 1));
}

std::vector<DesignPoint> CornersAndCentre(int dimension) {
  std::vector<DesignPoint> points;
  for (int corner = 0; corner < 1 << dimension; ++corner) {
    Eigen::VectorXd point(dimension);
    for (int k = 0; k < dimension; ++k) point[k] = (corner >> k) & 1;
    points.push_back({point, fmt::format("corner {}", corner + 1)});
  }
  points.push_back({Eigen::VectorXd::Constant(dimension, 0.5), "centre"});
  return points;
}

std::vector<DesignPoint> Labelled(const Eigen::MatrixXd& rows) {
  std::vector<DesignPoint> points;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    points.push_back({rows.row(i).transpose(), fmt::format("point {}", i + 1)});
  }
  return points;
}

Eigen::MatrixXd Grid(int levels, int dimension) {
  const auto count = static_cast<Eigen::Index>(std::llround(std::pow(levels, dimension)));
  Eigen::MatrixXd points(count, dimension);
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::Index rest = i;
    for (int k = 0; k < dimension; ++k) {
      points(i, k) = static_cast<double>(rest % levels) / (levels - 1);
      rest /= levels;
    }
  }
  return points;
}

Eigen::MatrixXd LatinHypercube(int count, int dimension, RandomStream* random) {
  Eigen::MatrixXd points(count, dimension);
  std::vector<int> strata(static_cast<std::size_t>(count));
  for (int k = 0; k < dimension; ++k) {
    std::iota(strata.begin(), strata.end(), 0);
    random->Shuffle(std::span(strata));
    for (int i = 0; i < count; ++i) {
      points(i, k) = (strata[static_cast<std::size_t>(i)] + random->Uniform()) / count;
    }
  }
  return points;
}

double SmallestDistance(const Eigen::MatrixXd& points) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 1; i < points.rows(); ++i) {
    smallest = std::min(
        smallest, (points.topRows(i).rowwise() - points.row(i)).rowwise().squaredNorm().minCoeff());
  }
  return smallest;
}

Eigen::MatrixXd MaximinLatinHypercube(int count, int dimension, std::uint64_t seed) {
  const RandomStream stream = RandomStream(seed).Split("latin_hypercube");
  // The search for distances costs count²; large designs are spread well enough by chance.
  const int trials = count <= 1000 ? kLatinHypercubes : 1;
  Eigen::MatrixXd best;
  double best_distance = -1;
  for (int trial = 0; trial < trials; ++trial) {
    RandomStream random = stream.Split(static_cast<std::uint64_t>(trial));
    Eigen::MatrixXd points = LatinHypercube(count, dimension, &random);
    const double distance = trials > 1 ? SmallestDistance(points) : 0;
    if (distance > best_distance) {
      best_distance = distance;
      best = std::move(points);
    }
  }
  return best;
}

// Ends included, as in a grid.
Eigen::MatrixXd OrthogonalPoints(int levels, int dimension) {
  return OrthogonalArray(levels).leftCols(dimension).cast<double>() / (levels - 1);
}

std::string ExplainNoOrthogonalArray(int levels, int dimension) {
  const auto known = OrthogonalArrayLevels();
  if (std::find(known.begin(), known.end(), levels) == known.end()) {
    const int nearest = *std::min_element(known.begin(), known.end(), [&](int a, int b) {
      return std::abs(a - levels) < std::abs(b - levels);
    });
    return fmt::format("there is no orthogonal array of {} levels (valid: {}); the nearest has {}",
                       levels, fmt::join(known, ", "), nearest);
  }
  if (dimension <= levels + 1) return "";
  const std::string reason =
      fmt::format("an orthogonal array of {} levels takes at most {} parameters and there are {}",
                  levels, levels + 1, dimension);
  const auto enough = std::lower_bound(known.begin(), known.end(), dimension - 1);
  if (enough == known.end()) return reason + "; use sobol or latin_hypercube";
  return reason + fmt::format("; use `levels: {}`, which has {} points, sobol or latin_hypercube",
                              *enough, *enough * *enough);
}

std::vector<DesignPoint> UserList(const DesignOptions& options, const SearchSpace& space) {
  std::vector<DesignPoint> points;
  for (const std::vector<double>& values : options.list) {
    const Eigen::VectorXd si =
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    points.push_back({space.ToUnit(si), fmt::format("point {}", points.size() + 1)});
  }
  return points;
}

std::vector<DesignPoint> PointsOf(const DesignOptions& options, const SearchSpace& space,
                                  std::uint64_t seed) {
  const int d = space.dimension();
  if (options.name == "corners_and_centre") return CornersAndCentre(d);
  if (options.name == "grid") return Labelled(Grid(options.levels, d));
  if (options.name == "list") return UserList(options, space);
  if (options.name == "orthogonal_array") return Labelled(OrthogonalPoints(options.levels, d));
  const int count = PointCount(options, d);
  if (options.name == "latin_hypercube") return Labelled(MaximinLatinHypercube(count, d, seed));
  if (options.name == "sobol") return Labelled(SobolPoints(count, d, seed));
  throw std::invalid_argument("MakeDesign: unknown design " + options.name);
}

}  // namespace

std::span<const std::string> DesignNames() { return kNames; }

std::string DesignOptions::ExplainUnsupported(const SearchSpace& space) const {
  const int d = space.dimension();
  if (name == "corners_and_centre" && d > kMaxCornerDimension) {
    return fmt::format(
        "corners_and_centre of {} parameters would have {:.3g} points (valid: at most "
        "{} parameters); use sobol or latin_hypercube",
        d, std::ldexp(1, d), kMaxCornerDimension);
  }
  if (name == "grid" && !(std::pow(levels, d) <= kMaxPoints)) {
    return fmt::format(
        "a grid of {} levels in {} parameters would have {:.3g} points (valid: at most "
        "{}); use fewer levels, sobol or latin_hypercube",
        levels, d, std::pow(levels, d), kMaxPoints);
  }
  if (name == "orthogonal_array") return ExplainNoOrthogonalArray(levels, d);
  if (name == "list" && list.empty()) return "the list of points is empty";
  for (const std::vector<double>& point : list) {
    if (name == "list" && static_cast<int>(point.size()) != d) {
      return fmt::format("a point of the list has {} values for {} parameters", point.size(), d);
    }
  }
  return "";
}

void DesignOptions::Serialize(Archive& archive, const SearchSpace& space) {
  const Range counts{.lower = 1, .upper = kMaxPoints};
  if (name == "sobol" || name == "latin_hypercube") {
    points = PointCount(*this, space.dimension());
    archive.Integer("points", points, counts);
  } else if (HasLevels(name)) {
    archive.Integer("levels", levels, {.lower = 2, .upper = kMaxPoints});
  } else if (name == "list") {
    archive.Require("points");
    if (archive.reading()) list.clear();
    std::size_t index = 0;
    archive.List("points", list.size(), [&](Archive& item) {
      if (item.reading()) list.emplace_back(space.parameters.size());
      std::vector<double>& values = list[index++];
      for (std::size_t k = 0; k < space.parameters.size(); ++k) {
        const Parameter& parameter = space.parameters[k];
        item.Require(parameter.name);
        item.Quantity(parameter.name, values[k], parameter.unit,
                      {.lower = parameter.lower, .upper = parameter.upper});
      }
    });
  }
  if (!archive.reading()) return;
  const std::string reason = ExplainUnsupported(space);
  const char* key = HasLevels(name) ? "levels" : name == "list" ? "points" : "name";
  if (!reason.empty()) throw archive.ErrorAt(key, reason);
}

void DesignOptions::SerializeSection(Archive& archive, std::string_view key,
                                     const SearchSpace& space) {
  archive.Section(
      key,
      [&](Archive& section) {
        const std::string before = name;
        section.Choice("name", name, "design", kNames);
        if (name != before) points = 0;  // the default count of another design does not carry over
        Serialize(section, space);
      },
      "name");
}

std::vector<DesignPoint> MakeDesign(const DesignOptions& options, const SearchSpace& space,
                                    std::uint64_t seed) {
  const std::string reason = options.ExplainUnsupported(space);
  if (!reason.empty()) throw std::invalid_argument("MakeDesign: " + reason);
  std::vector<DesignPoint> points = PointsOf(options, space, seed);
  for (DesignPoint& point : points) point.point = space.Snap(point.point);
  return points;
}

Eigen::MatrixXd SobolPoints(int count, int dimension, std::uint64_t seed) {
  RandomStream random = RandomStream(seed).Split("sobol");
  std::vector<std::uint32_t> shift(static_cast<std::size_t>(dimension));
  for (std::uint32_t& bits : shift) bits = static_cast<std::uint32_t>(random.Bits() >> 32);
  boost::random::sobol_engine<std::uint32_t, 32> engine(static_cast<std::size_t>(dimension));
  Eigen::MatrixXd points(count, dimension);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < dimension; ++k) {
      // The engine leaves out the sequence's first point, the origin, without which the first 2^m
      // points are not a net.
      const std::uint32_t bits = i == 0 ? 0 : static_cast<std::uint32_t>(engine());
      points(i, k) =
          (static_cast<double>(bits ^ shift[static_cast<std::size_t>(k)]) + 0.5) * 0x1p-32;
    }
  }
  return points;
}

}  // namespace powdercal
