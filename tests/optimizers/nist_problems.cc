#include "tests/optimizers/nist_problems.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/table.h"

namespace powdercal {
namespace {

constexpr double kPi = std::numbers::pi;

double Square(double value) { return value * value; }

double Bennett5(const double* b, const double* x) {
  return b[0] * std::pow(b[1] + x[0], -1 / b[2]);
}

double BoxBod(const double* b, const double* x) { return b[0] * (1 - std::exp(-b[1] * x[0])); }

double Chwirut(const double* b, const double* x) {
  return std::exp(-b[0] * x[0]) / (b[1] + b[2] * x[0]);
}

double DanWood(const double* b, const double* x) { return b[0] * std::pow(x[0], b[1]); }

double Enso(const double* b, const double* x) {
  const auto wave = [&](double cosine, double sine, double period) {
    const double phase = 2 * kPi * x[0] / period;
    return cosine * std::cos(phase) + sine * std::sin(phase);
  };
  return b[0] + wave(b[1], b[2], 12) + wave(b[4], b[5], b[3]) + wave(b[7], b[8], b[6]);
}

double Eckerle4(const double* b, const double* x) {
  return b[0] / b[1] * std::exp(-0.5 * Square((x[0] - b[2]) / b[1]));
}

double Gauss(const double* b, const double* x) {
  return b[0] * std::exp(-b[1] * x[0]) + b[2] * std::exp(-Square((x[0] - b[3]) / b[4])) +
         b[5] * std::exp(-Square((x[0] - b[6]) / b[7]));
}

// Hahn1 and Thurber.
double Cubics(const double* b, const double* x) {
  const double t = x[0];
  return (b[0] + t * (b[1] + t * (b[2] + t * b[3]))) / (1 + t * (b[4] + t * (b[5] + t * b[6])));
}

// Kirby2.
double Quadratics(const double* b, const double* x) {
  const double t = x[0];
  return (b[0] + t * (b[1] + t * b[2])) / (1 + t * (b[3] + t * b[4]));
}

double Lanczos(const double* b, const double* x) {
  return b[0] * std::exp(-b[1] * x[0]) + b[2] * std::exp(-b[3] * x[0]) +
         b[4] * std::exp(-b[5] * x[0]);
}

double Mgh09(const double* b, const double* x) {
  const double t = x[0];
  return b[0] * t * (t + b[1]) / (t * (t + b[2]) + b[3]);
}

double Mgh10(const double* b, const double* x) { return b[0] * std::exp(b[1] / (x[0] + b[2])); }

double Mgh17(const double* b, const double* x) {
  return b[0] + b[1] * std::exp(-x[0] * b[3]) + b[2] * std::exp(-x[0] * b[4]);
}

double Misra1a(const double* b, const double* x) { return b[0] * (1 - std::exp(-b[1] * x[0])); }

double Misra1b(const double* b, const double* x) {
  return b[0] * (1 - 1 / Square(1 + b[1] * x[0] / 2));
}

double Misra1c(const double* b, const double* x) {
  return b[0] * (1 - 1 / std::sqrt(1 + 2 * b[1] * x[0]));
}

double Misra1d(const double* b, const double* x) { return b[0] * b[1] * x[0] / (1 + b[1] * x[0]); }

// Of log y.
double Nelson(const double* b, const double* x) {
  return b[0] - b[1] * x[0] * std::exp(-b[2] * x[1]);
}

double Rat42(const double* b, const double* x) { return b[0] / (1 + std::exp(b[1] - b[2] * x[0])); }

double Rat43(const double* b, const double* x) {
  return b[0] / std::pow(1 + std::exp(b[1] - b[2] * x[0]), 1 / b[3]);
}

double Roszman1(const double* b, const double* x) {
  return b[0] - b[1] * x[0] - std::atan(b[2] / (x[0] - b[3])) / kPi;
}

// Name, model, residual sum of squares and standard deviation; for each parameter the starts and
// the certified value.
const std::vector<NistProblem> kProblems = {
    {"Bennett5",
     Bennett5,
     5.2404744073e-4,
     1.8629312528e-3,
     {{-2000, -1500, -2.5235058043e3}, {50, 45, 4.6736564644e1}, {0.8, 0.85, 9.3218483193e-1}}},
    {"BoxBOD",
     BoxBod,
     1.1680088766e3,
     1.7088072423e1,
     {{1, 100, 2.1380940889e2}, {1, 0.75, 5.4723748542e-1}}},
    {"Chwirut1",
     Chwirut,
     2.3844771393e3,
     3.3616721320,
     {{0.1, 0.15, 1.9027818370e-1},
      {0.01, 0.008, 6.1314004477e-3},
      {0.02, 0.010, 1.0530908399e-2}}},
    {"Chwirut2",
     Chwirut,
     5.1304802941e2,
     3.1717133040,
     {{0.1, 0.15, 1.6657666537e-1},
      {0.01, 0.008, 5.1653291286e-3},
      {0.02, 0.010, 1.2150007096e-2}}},
    {"DanWood",
     DanWood,
     4.3173084083e-3,
     3.2853114039e-2,
     {{1, 0.7, 7.6886226176e-1}, {5, 4, 3.8604055871}}},
    {"ENSO",
     Enso,
     7.8853978668e2,
     2.2269642403,
     {{11.0, 10.0, 1.0510749193e1},
      {3.0, 3.0, 3.0762128085},
      {0.5, 0.5, 5.3280138227e-1},
      {40.0, 44.0, 4.4311088700e1},
      {-0.7, -1.5, -1.6231428586},
      {-1.3, 0.5, 5.2554493756e-1},
      {25.0, 26.0, 2.6887614440e1},
      {-0.3, -0.1, 2.1232288488e-1},
      {1.4, 1.5, 1.4966870418}}},
    {"Eckerle4",
     Eckerle4,
     1.4635887487e-3,
     6.7629245447e-3,
     {{1, 1.5, 1.5543827178}, {10, 5, 4.0888321754}, {500, 450, 4.5154121844e2}}},
    {"Gauss1",
     Gauss,
     1.3158222432e3,
     2.3317980180,
     {{97.0, 94.0, 9.8778210871e1},
      {0.009, 0.0105, 1.0497276517e-2},
      {100.0, 99.0, 1.0048990633e2},
      {65.0, 63.0, 6.7481111276e1},
      {20.0, 25.0, 2.3129773360e1},
      {70.0, 71.0, 7.1994503004e1},
      {178.0, 180.0, 1.7899805021e2},
      {16.5, 20.0, 1.8389389025e1}}},
    {"Gauss2",
     Gauss,
     1.2475282092e3,
     2.2704790782,
     {{96.0, 98.0, 9.9018328406e1},
      {0.009, 0.0105, 1.0994945399e-2},
      {103.0, 103.0, 1.0188022528e2},
      {106.0, 105.0, 1.0703095519e2},
      {18.0, 20.0, 2.3578584029e1},
      {72.0, 73.0, 7.2045589471e1},
      {151.0, 150.0, 1.5327010194e2},
      {18.0, 20.0, 1.9525972636e1}}},
    {"Gauss3",
     Gauss,
     1.2444846360e3,
     2.2677077625,
     {{94.9, 96.0, 9.8940368970e1},
      {0.009, 0.0096, 1.0945879335e-2},
      {90.1, 80.0, 1.0069553078e2},
      {113.0, 110.0, 1.1163619459e2},
      {20.0, 25.0, 2.3300500029e1},
      {73.8, 74.0, 7.3705031418e1},
      {140.0, 139.0, 1.4776164251e2},
      {20.0, 25.0, 1.9668221230e1}}},
    {"Hahn1",
     Cubics,
     1.5324382854,
     8.1803852243e-2,
     {{10, 1, 1.0776351733},
      {-1, -0.1, -1.2269296921e-1},
      {0.05, 0.005, 4.0863750610e-3},
      {-0.00001, -0.000001, -1.4262662514e-6},
      {-0.05, -0.005, -5.7609940901e-3},
      {0.001, 0.0001, 2.4053735503e-4},
      {-0.000001, -0.0000001, -1.2314450199e-7}}},
    {"Kirby2",
     Quadratics,
     3.9050739624,
     1.6354535131e-1,
     {{2, 1.5, 1.6745063063},
      {-0.1, -0.15, -1.3927397867e-1},
      {0.003, 0.0025, 2.5961181191e-3},
      {-0.001, -0.0015, -1.7241811870e-3},
      {0.00001, 0.00002, 2.1664802578e-5}}},
    {"Lanczos1",
     Lanczos,
     1.4307867721e-25,
     8.9156129349e-14,
     {{1.2, 0.5, 9.5100000027e-2},
      {0.3, 0.7, 1.0000000001},
      {5.6, 3.6, 8.6070000013e-1},
      {5.5, 4.2, 3.0000000002},
      {6.5, 4, 1.5575999998},
      {7.6, 6.3, 5.0000000001}}},
    {"Lanczos2",
     Lanczos,
     2.2299428125e-11,
     1.1130395851e-6,
     {{1.2, 0.5, 9.6251029939e-2},
      {0.3, 0.7, 1.0057332849},
      {5.6, 3.6, 8.6424689056e-1},
      {5.5, 4.2, 3.0078283915},
      {6.5, 4, 1.5529016879},
      {7.6, 6.3, 5.0028798100}}},
    {"Lanczos3",
     Lanczos,
     1.6117193594e-8,
     2.9923229172e-5,
     {{1.2, 0.5, 8.6816414977e-2},
      {0.3, 0.7, 9.5498101505e-1},
      {5.6, 3.6, 8.4400777463e-1},
      {5.5, 4.2, 2.9515951832},
      {6.5, 4, 1.5825685901},
      {7.6, 6.3, 4.9863565084}}},
    {"MGH09",
     Mgh09,
     3.0750560385e-4,
     6.6279236551e-3,
     {{25, 0.25, 1.9280693458e-1},
      {39, 0.39, 1.9128232873e-1},
      {41.5, 0.415, 1.2305650693e-1},
      {39, 0.39, 1.3606233068e-1}}},
    {"MGH10",
     Mgh10,
     8.7945855171e1,
     2.6009740065,
     {{2, 0.02, 5.6096364710e-3}, {400000, 4000, 6.1813463463e3}, {25000, 250, 3.4522363462e2}}},
    {"MGH17",
     Mgh17,
     5.4648946975e-5,
     1.3970497866e-3,
     {{50, 0.5, 3.7541005211e-1},
      {150, 1.5, 1.9358469127},
      {-100, -1, -1.4646871366},
      {1, 0.01, 1.2867534640e-2},
      {2, 0.02, 2.2122699662e-2}}},
    {"Misra1a",
     Misra1a,
     1.2455138894e-1,
     1.0187876330e-1,
     {{500, 250, 2.3894212918e2}, {0.0001, 0.0005, 5.5015643181e-4}}},
    {"Misra1b",
     Misra1b,
     7.5464681533e-2,
     7.9301471998e-2,
     {{500, 300, 3.3799746163e2}, {0.0001, 0.0002, 3.9039091287e-4}}},
    {"Misra1c",
     Misra1c,
     4.0966836971e-2,
     5.8428615257e-2,
     {{500, 600, 6.3642725809e2}, {0.0001, 0.0002, 2.0813627256e-4}}},
    {"Misra1d",
     Misra1d,
     5.6419295283e-2,
     6.8568272111e-2,
     {{500, 450, 4.3736970754e2}, {0.0001, 0.0003, 3.0227324449e-4}}},
    {"Nelson",
     Nelson,
     3.7976833176,
     1.7430280130e-1,
     {{2, 2.5, 2.5906836021},
      {0.0001, 0.000000005, 5.6177717026e-9},
      {-0.01, -0.05, -5.7701013174e-2}}},
    {"Rat42",
     Rat42,
     8.0565229338,
     1.1587725499,
     {{100, 75, 7.2462237576e1}, {1, 2.5, 2.6180768402}, {0.1, 0.07, 6.7359200066e-2}}},
    {"Rat43",
     Rat43,
     8.7864049080e3,
     2.8262414662e1,
     {{100, 700, 6.9964151270e2},
      {10, 5, 5.2771253025},
      {1, 0.75, 7.5962938329e-1},
      {1, 1.3, 1.2792483859}}},
    {"Roszman1",
     Roszman1,
     4.9484847331e-4,
     4.8542984060e-3,
     {{0.1, 0.2, 2.0196866396e-1},
      {-0.00001, -0.000005, -6.1953516256e-6},
      {1000, 1200, 1.2044556708e3},
      {-100, -150, -1.8134269537e2}}},
    {"Thurber",
     Cubics,
     5.6427082397e3,
     1.3714600784e1,
     {{1000, 1300, 1.2881396800e3},
      {1000, 1500, 1.4910792535e3},
      {400, 500, 5.8323836877e2},
      {40, 75, 7.5416644291e1},
      {0.7, 1, 9.6629502864e-1},
      {0.3, 0.4, 3.9797285797e-1},
      {0.03, 0.05, 4.9727297349e-2}}},
};

}  // namespace

std::span<const NistProblem> NistProblems() { return kProblems; }

std::vector<NistProblem::Row> NistProblem::Data() const {
  const Table table =
      Table::ReadCsv(std::string(POWDERCAL_SOURCE_DIR) + "/tests/optimizers/nist/" + name + ".csv");
  std::vector<Row> rows(table.row_count());
  const auto& first = table.Get(table.Has("x") ? "x" : "x1", "1").values;
  const auto& y = table.Get("y", "1").values;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = {{first[i], table.Has("x2") ? table.Get("x2", "1").values[i] : 0}, y[i]};
    if (name == "Nelson") rows[i].y = std::log(rows[i].y);
  }
  return rows;
}

SearchSpace NistProblem::Space() const {
  SearchSpace space;
  for (const Parameter& parameter : parameters) {
    const auto [low, high] =
        std::minmax({parameter.start[0], parameter.start[1], parameter.certified});
    const double larger = std::max(std::abs(low), std::abs(high));
    const double smaller = std::min(std::abs(low), std::abs(high));
    const std::string symbol = fmt::format("b{}", space.parameters.size() + 1);
    powdercal::Parameter entry{.name = symbol, .symbol = symbol, .unit = "1"};
    if (low * high > 0 && larger > 20 * smaller) {
      entry.logarithmic = low > 0;
      entry.lower = low > 0 ? low / 10 : low * 10;
      entry.upper = low > 0 ? high * 10 : high / 10;
    } else {
      const double margin = std::max(high - low, larger / 2);
      entry.lower = low - margin;
      entry.upper = high + margin;
      if (low > 0) entry.lower = std::max(entry.lower, low / 10);
      if (high < 0) entry.upper = std::min(entry.upper, high / 10);
    }
    space.parameters.push_back(entry);
  }
  return space;
}

Objectives NistProblem::Targets() const {
  const std::vector<Row> data = Data();
  double largest = 0;
  for (const Row& row : data) largest = std::max(largest, std::abs(row.y));
  Objectives objectives;
  for (const Row& row : data) {
    objectives.targets.push_back({.response = fmt::format("y{}", objectives.targets.size()),
                                  .unit = "1",
                                  .value = row.y,
                                  .sd = std::max(residual_sd, 1e-9 * largest)});
  }
  return objectives;
}

}  // namespace powdercal
