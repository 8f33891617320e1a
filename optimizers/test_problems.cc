#include "optimizers/test_problems.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/errors.h"
#include "core/random.h"
#include "core/table.h"
#include "optimizers/pareto.h"
#include "surrogates/gaussian_process.h"

namespace powdercal {
namespace {

using std::numbers::pi;
using Responses = std::span<const Eigen::VectorXd>;

constexpr double kNone = std::numeric_limits<double>::infinity();

SearchSpace Box(int dimension) {
  SearchSpace space;
  for (int k = 0; k < dimension; ++k) {
    const std::string name = fmt::format("x{}", k + 1);
    space.parameters.push_back({.name = name, .symbol = name, .unit = "1"});
  }
  return space;
}

Parameter Named(const std::string& name, double lower, double upper) {
  return {.name = name, .symbol = name, .unit = "1", .lower = lower, .upper = upper};
}

// One objective for each response, the response itself.
Objectives Minimised(int count) {
  Objectives objectives;
  if (count > 1) objectives.kind = Objectives::Kind::pareto;
  for (int o = 0; o < count; ++o) {
    objectives.targets.push_back({.response = fmt::format("f{}", o + 1),
                                  .unit = "1",
                                  .sd = 1,
                                  .objective = o,
                                  .minimise = true});
  }
  return objectives;
}

// Lowest first response − optimum.
auto Regret(double optimum) {
  return [optimum](Responses responses) {
    double best = kNone;
    for (const Eigen::VectorXd& response : responses) {
      if (response.size() > 0) best = std::min(best, response[0]);
    }
    return best - optimum;
  };
}

Eigen::MatrixXd Rows(Responses responses, Eigen::Index columns) {
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(responses.size()), columns, kNone);
  for (std::size_t i = 0; i < responses.size(); ++i) {
    if (responses[i].size() > 0) rows.row(static_cast<Eigen::Index>(i)) = responses[i].transpose();
  }
  return rows;
}

auto HypervolumeBelow(const Eigen::VectorXd& reference) {
  return [reference](Responses responses) {
    return Hypervolume(Rows(responses, reference.size()), reference);
  };
}

// Evaluations until `reached`; all of them and one more where it never was.
auto EvaluationsUntil(std::function<bool(const Eigen::VectorXd&)> reached) {
  return [reached](Responses responses) {
    const auto first = std::find_if(
        responses.begin(), responses.end(),
        [&](const Eigen::VectorXd& response) { return response.size() > 0 && reached(response); });
    return static_cast<double>(first - responses.begin() + 1);
  };
}

// Dixon & Szegö 1978. x in [−5, 10] × [0, 15].
double Branin(double x, double y) {
  const double a = y - 5.1 / (4 * pi * pi) * x * x + 5 / pi * x - 6;
  return a * a + 10 * (1 - 1 / (8 * pi)) * std::cos(x) + 10;
}
constexpr double kBraninMinimum = 0.39788735772973816;

TestProblem MakeBranin() {
  TestProblem problem{.description = "Branin's function (Dixon & Szego 1978), 5 + 30 evaluations",
                      .objectives = Minimised(1),
                      .initial_design = {.name = "sobol", .points = 5},
                      .evaluations = 35,
                      .measure = Regret(kBraninMinimum),
                      .measured = "regret of the best point evaluated"};
  problem.space.parameters = {Named("x1", -5, 10), Named("x2", 0, 15)};
  problem.respond = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd::Constant(1, Branin(x[0], x[1]));
  };
  return problem;
}

// Branin's function with a fidelity s that shifts the coefficient of x1² by (1 − s)/10 (Wu,
// Toscano-Palmerin, Frazier & Wilson 2020, section 5). The target is Branin's function itself.
TestProblem MakeMultiFidelityBranin() {
  constexpr double kShift = 0.1;
  TestProblem problem = MakeBranin();
  problem.description =
      "Branin with cheap approximations (Wu et al. 2020), cost 0.1 and 0.3 of the target's";
  problem.fidelities = {{0.5, 0.1}, {0.8, 0.3}, {1, 1}};
  problem.respond_at = [](const Eigen::VectorXd& x, double fidelity) {
    const double shifted = x[1] + kShift * (1 - fidelity) * x[0] * x[0];
    return Eigen::VectorXd::Constant(1, Branin(x[0], shifted));
  };
  return problem;
}

// The same Hartmann function as in Dixon & Szegö 1978, 6 inputs.
double Hartmann6(const Eigen::VectorXd& x) {
  static const Eigen::Matrix<double, 4, 6> kA{{10, 3, 17, 3.5, 1.7, 8},
                                              {0.05, 10, 17, 0.1, 8, 14},
                                              {3, 3.5, 1.7, 10, 17, 8},
                                              {17, 8, 0.05, 10, 0.1, 14}};
  static const Eigen::Matrix<double, 4, 6> kP{{0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886},
                                              {0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991},
                                              {0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650},
                                              {0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381}};
  constexpr std::array<double, 4> kAlpha = {1.0, 1.2, 3.0, 3.2};
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const double distance =
        (kA.row(i).transpose().array() * (x - kP.row(i).transpose()).array().square()).sum();
    sum -= kAlpha[static_cast<std::size_t>(i)] * std::exp(-distance);
  }
  return sum;
}
constexpr double kHartmann6Minimum = -3.32236801141551;

TestProblem MakeHartmann6(double noise_sd) {
  TestProblem problem{.description = "Hartmann's function of 6 inputs (Dixon & Szego 1978)",
                      .space = Box(6),
                      .objectives = Minimised(1),
                      .initial_design = {.name = "sobol", .points = 10},
                      .evaluations = 50,
                      .measure = Regret(kHartmann6Minimum),
                      .measured = "noise-free regret of the best point evaluated"};
  if (noise_sd > 0) {
    problem.noise_sd = Eigen::VectorXd::Constant(1, noise_sd);
    problem.description += fmt::format(", noise of sd {:g}", noise_sd);
  }
  problem.respond = [](const Eigen::VectorXd& x) {
    return Eigen::VectorXd::Constant(1, Hartmann6(x));
  };
  return problem;
}

// Concentration of a pollutant at 3 places and 4 times after two spills (Bliznyuk, Ruppert,
// Shoemaker et al. 2008, section 5; ranges and true values of Astudillo & Frazier 2019).
Eigen::VectorXd Concentrations(const Eigen::VectorXd& x) {
  constexpr std::array<double, 3> kPlaces = {0, 1, 2.5};
  constexpr std::array<double, 4> kTimes = {15, 30, 45, 60};
  const double mass = x[0];
  const double diffusion = x[1];
  const double place = x[2];
  const double time = x[3];
  Eigen::VectorXd concentrations(12);
  Eigen::Index i = 0;
  for (const double s : kPlaces) {
    for (const double t : kTimes) {
      double c = mass / std::sqrt(4 * pi * diffusion * t) * std::exp(-s * s / (4 * diffusion * t));
      if (t > time) {
        const double since = t - time;
        c += mass / std::sqrt(4 * pi * diffusion * since) *
             std::exp(-(s - place) * (s - place) / (4 * diffusion * since));
      }
      concentrations[i++] = c;
    }
  }
  return concentrations;
}

TestProblem MakeEnvironmental(double noise_sd) {
  TestProblem problem{
      .description = "environmental model (Bliznyuk et al. 2008): 4 parameters, 12 responses",
      .initial_design = {.name = "sobol", .points = 10},
      .evaluations = 20,
      .measured = "noise-free sum of squares of the best point evaluated"};
  problem.space.parameters = {Named("M", 7, 13), Named("D", 0.02, 0.12), Named("L", 0.01, 3),
                              Named("tau", 30.01, 30.295)};
  const Eigen::VectorXd truth = Concentrations(Eigen::Vector4d(10, 0.07, 1.505, 30.1525));
  for (const double value : truth) {
    problem.objectives.targets.push_back(
        {.response = fmt::format("c{}", problem.objectives.targets.size() + 1),
         .unit = "1",
         .value = value,
         .sd = 1});
  }
  if (noise_sd > 0) {
    problem.noise_sd = Eigen::VectorXd::Constant(truth.size(), noise_sd);
    problem.description += fmt::format(", noise of sd {:g}", noise_sd);
  }
  problem.respond = Concentrations;
  problem.measure = [truth](Responses responses) {
    double best = kNone;
    for (const Eigen::VectorXd& response : responses) {
      if (response.size() > 0) best = std::min(best, (response - truth).squaredNorm());
    }
    return best;
  };
  return problem;
}

// Branin and Currin's exponential function, both on the unit square, as in Daulton, Balandat &
// Bakshy 2020 (appendix, with the signs turned).
Eigen::VectorXd BraninCurrin(const Eigen::VectorXd& x) {
  const double u = x[0];
  const double v = x[1];
  const double factor = v > 0 ? 1 - std::exp(-1 / (2 * v)) : 1;
  const double currin = factor * (2300 * u * u * u + 1900 * u * u + 2092 * u + 60) /
                        (100 * u * u * u + 500 * u * u + 4 * u + 20);
  return Eigen::Vector2d(Branin(15 * u - 5, 15 * v), currin);
}
const Eigen::Vector2d kBraninCurrinReference(18, 6);
constexpr double kBraninCurrinHypervolume = 59.36011874867746;

TestProblem MakeBraninCurrin() {
  TestProblem problem{.description = "Branin and Currin (Daulton et al. 2020), 36 evaluations",
                      .space = Box(2),
                      .objectives = Minimised(2),
                      .initial_design = {.name = "sobol", .points = 6},
                      .evaluations = 36,
                      .respond = BraninCurrin,
                      .measured = "log10 of the hypervolume that is missing below (18, 6)"};
  problem.objectives.reference = {kBraninCurrinReference[0], kBraninCurrinReference[1]};
  problem.measure = [](Responses responses) {
    return std::log10(kBraninCurrinHypervolume -
                      Hypervolume(Rows(responses, 2), kBraninCurrinReference));
  };
  return problem;
}

TestProblem MakeNoisyBraninCurrin() {
  TestProblem problem = MakeBraninCurrin();
  problem.description = "Branin and Currin, noise of sd 15.19 and 0.63, 6 + 20 batches of 4";
  problem.noise_sd = Eigen::Vector2d(15.19, 0.63);
  problem.evaluations = 86;
  problem.batch = 4;
  problem.measure = HypervolumeBelow(kBraninCurrinReference);
  problem.measured = "hypervolume below (18, 6) of the noise-free values of all points evaluated";
  problem.higher_is_better = true;
  return problem;
}

TestProblem MakeZdt1() {  // Zitzler, Deb & Thiele 2000
  TestProblem problem{.description = "ZDT1 (Zitzler, Deb & Thiele 2000), 30 parameters",
                      .space = Box(30),
                      .objectives = Minimised(2),
                      .initial_design = {.name = "sobol", .points = 40},
                      .evaluations = 4040,
                      .modelled_evaluations = 120,
                      .batch = 40,
                      .measure = HypervolumeBelow(Eigen::Vector2d(1.1, 1.1)),
                      .measured = "hypervolume below (1.1, 1.1)",
                      .higher_is_better = true};
  problem.objectives.reference = {1.1, 1.1};
  problem.respond = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const double g = 1 + 9 * x.tail(x.size() - 1).mean();
    return Eigen::Vector2d(x[0], g * (1 - std::sqrt(x[0] / g)));
  };
  return problem;
}

TestProblem MakeDtlz2() {  // Deb, Thiele, Laumanns & Zitzler 2002
  TestProblem problem{.description = "DTLZ2 (Deb et al. 2002), 12 parameters, 3 objectives",
                      .space = Box(12),
                      .objectives = Minimised(3),
                      .initial_design = {.name = "sobol", .points = 92},
                      .evaluations = 4048,
                      .modelled_evaluations = 184,
                      .batch = 92,
                      .measure = HypervolumeBelow(Eigen::Vector3d::Constant(1.1)),
                      .measured = "hypervolume below (1.1, 1.1, 1.1)",
                      .higher_is_better = true};
  problem.objectives.reference = {1.1, 1.1, 1.1};
  problem.respond = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    const double radius = 1 + (x.tail(x.size() - 2).array() - 0.5).square().sum();
    const double a = x[0] * pi / 2;
    const double b = x[1] * pi / 2;
    return radius *
           Eigen::Vector3d(std::cos(a) * std::cos(b), std::cos(a) * std::sin(b), std::sin(a));
  };
  return problem;
}

// Own: the best place in two continuous inputs depends on a count and on a kind; ripples along the
// first. Minimum 0 at kind = b, n = 5, x1 = 0.5, x2 = 0.6.
TestProblem MakeMixed() {
  TestProblem problem{
      .description = "two continuous parameters, an integer of 8 levels and 3 categories",
      .objectives = Minimised(1),
      .initial_design = {.name = "sobol", .points = 8},
      .evaluations = 40,
      .measure = Regret(0),
      .measured = "regret of the best point evaluated"};
  Parameter count = Named("n", 1, 8);
  count.kind = Parameter::Kind::integer;
  Parameter kind = Named("kind", 0, 2);
  kind.kind = Parameter::Kind::categorical;
  kind.categories = {"a", "b", "c"};
  problem.space.parameters = {Named("x1", 0, 1), Named("x2", 0, 1), count, kind};
  problem.respond = [](const Eigen::VectorXd& x) {
    constexpr std::array<double, 3> kPlace = {0.2, 0.5, 0.8};
    constexpr std::array<double, 3> kCount = {2, 5, 7};
    constexpr std::array<double, 3> kHeight = {0.3, 0, 0.15};
    const auto c = static_cast<std::size_t>(x[3]);
    const double along = x[0] - kPlace[c];
    const double across = x[1] - 0.2 - 0.08 * x[2];
    const double counted = x[2] - kCount[c];
    return Eigen::VectorXd::Constant(1, along * along + across * across + 0.02 * counted * counted +
                                            0.1 * (1 - std::cos(3 * pi * along)) + kHeight[c]);
  };
  return problem;
}

// Regret at which Branin counts as solved where evaluations are counted.
constexpr double kBraninSolved = 1e-2;

TestProblem MakeFailures(bool failing) {
  TestProblem problem = MakeBranin();
  problem.description =
      "Branin of which a third of the box fails (x1 < 0), one of its three minima in it";
  problem.evaluations = 100;
  problem.measure = EvaluationsUntil(
      [](const Eigen::VectorXd& f) { return f[0] - kBraninMinimum <= kBraninSolved; });
  problem.measured = fmt::format("evaluations until the regret is at most {:g}", kBraninSolved);
  if (failing) {
    problem.respond = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      if (x[0] < 0) return {};
      return Eigen::VectorXd::Constant(1, Branin(x[0], x[1]));
    };
  }
  return problem;
}

TestProblem MakeTable3(const std::filesystem::path& path) {
  constexpr double kTarget = 0.783;
  constexpr double kTolerance = 0.007;
  TestProblem problem{
      .description = "the paper's Table 3 by a Gaussian process: to within 0.007 of e = 0.783",
      .initial_design = {.name = "list",
                         .list = {{1e2, 0.05}, {1e5, 0.7}, {1e2, 0.7}, {1e5, 0.05}, {5e2, 0.4}}},
      .evaluations = 100,
      .measured = "evaluations until |e - 0.783| < 0.007, the five initial cases included"};
  problem.space.parameters = {{.name = "cohesion_energy_density",
                               .symbol = "k",
                               .unit = "J/m3",
                               .lower = 1e2,
                               .upper = 1e5},
                              Named("rolling_friction", 0.05, 0.7)};
  problem.objectives.targets = {
      {.response = "consolidation.void_ratio", .unit = "1", .value = kTarget, .sd = 0.01}};
  const Table table = Table::ReadCsv(path.string());
  const SearchSpace space = problem.space;
  Eigen::MatrixXd points(static_cast<Eigen::Index>(table.row_count()), 2);
  Eigen::VectorXd values(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto row = static_cast<std::size_t>(i);
    Eigen::Vector2d si;
    for (Eigen::Index k = 0; k < 2; ++k) {
      const Parameter& parameter = space.parameters[static_cast<std::size_t>(k)];
      si[k] = table.Get(parameter.name, parameter.unit).values[row];
    }
    points.row(i) = space.ToUnit(si).transpose();
    values[i] = table.Get("consolidation.void_ratio", "1").values[row];
  }
  GaussianProcess process;
  process.Fit(points, values, {});
  problem.respond = [process, space](const Eigen::VectorXd& si) {
    return Eigen::VectorXd::Constant(1, process.Predict(space.ToUnit(si)).mean);
  };
  problem.measure = EvaluationsUntil(
      [](const Eigen::VectorXd& e) { return std::abs(e[0] - kTarget) < kTolerance; });
  return problem;
}

struct Entry {
  const char* name;
  TestProblem (*make)(const std::filesystem::path& table3);
};

using Path = const std::filesystem::path&;
constexpr double kHartmannNoise = 0.1;
constexpr double kEnvironmentalNoise = 0.05;
constexpr std::array<Entry, 13> kProblems = {{
    {"branin", [](Path) { return MakeBranin(); }},
    {"branin_currin", [](Path) { return MakeBraninCurrin(); }},
    {"branin_currin_noisy", [](Path) { return MakeNoisyBraninCurrin(); }},
    {"branin_multi_fidelity", [](Path) { return MakeMultiFidelityBranin(); }},
    {"dtlz2", [](Path) { return MakeDtlz2(); }},
    {"environmental", [](Path) { return MakeEnvironmental(0); }},
    {"environmental_noisy", [](Path) { return MakeEnvironmental(kEnvironmentalNoise); }},
    {"failures", [](Path) { return MakeFailures(true); }},
    {"hartmann6", [](Path) { return MakeHartmann6(0); }},
    {"hartmann6_noisy", [](Path) { return MakeHartmann6(kHartmannNoise); }},
    {"mixed", [](Path) { return MakeMixed(); }},
    {"table3", [](Path path) { return MakeTable3(path); }},
    {"zdt1", [](Path) { return MakeZdt1(); }},
}};

}  // namespace

std::span<const std::string> TestProblemNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Entry& entry : kProblems) result.emplace_back(entry.name);
    return result;
  }();
  return names;
}

TestProblem MakeTestProblem(const std::string& name, const std::filesystem::path& table3) {
  for (const Entry& entry : kProblems) {
    if (name != entry.name) continue;
    TestProblem problem = entry.make(table3);
    problem.name = name;
    return problem;
  }
  throw UnknownName("problem", name, TestProblemNames());
}

TestProblem MakeFailuresWithoutFailing() {
  TestProblem problem = MakeFailures(false);
  problem.name = "failures";
  problem.description = "Branin, until it is solved";
  return problem;
}

double CostOf(const TestProblem& problem, const Candidate& candidate) {
  for (const FidelityLevel& level : problem.fidelities) {
    if (level.fidelity == candidate.fidelity) return level.cost;
  }
  return 1;
}

Observation Observe(const TestProblem& problem, const Candidate& candidate, std::uint64_t seed) {
  Observation observation{
      .id = candidate.id, .point = candidate.point, .fidelity = candidate.fidelity};
  const Eigen::VectorXd values = problem.space.FromUnit(candidate.point);
  observation.responses = candidate.fidelity < 1 ? problem.respond_at(values, candidate.fidelity)
                                                 : problem.respond(values);
  if (observation.responses.size() == 0) {
    observation.failed = true;
    observation.failure = "the problem fails here";
    return observation;
  }
  observation.variances = Eigen::VectorXd::Zero(observation.responses.size());
  if (problem.noise_sd.size() == 0) return observation;
  RandomStream random =
      RandomStream(seed).Split("noise").Split(static_cast<std::uint64_t>(candidate.id));
  for (Eigen::Index j = 0; j < problem.noise_sd.size(); ++j) {
    observation.responses[j] += problem.noise_sd[j] * random.Normal();
    observation.variances[j] = problem.noise_sd[j] * problem.noise_sd[j];
  }
  return observation;
}

}  // namespace powdercal
