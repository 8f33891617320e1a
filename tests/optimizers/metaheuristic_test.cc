// What all metaheuristics have in common: asking, telling, failing, ending.
#include "optimizers/metaheuristics/metaheuristic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "tests/optimizers/metaheuristics.h"

namespace powdercal {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// Smooth, with the optima of its one or two objectives apart.
Eigen::VectorXd Bowls(const Eigen::VectorXd& x, int objectives) {
  Eigen::VectorXd values(objectives);
  for (int o = 0; o < objectives; ++o) {
    values[o] = (x.array() - 0.3 - 0.4 * o)
                    .square()
                    .matrix()
                    .dot(Eigen::VectorXd::LinSpaced(x.size(), 1, 5));
  }
  return values;
}

class MetaheuristicTest : public testing::TestWithParam<MetaheuristicCase> {
 protected:
  std::unique_ptr<Optimizer> Make(std::uint64_t seed, const std::string& more = "",
                                  const SearchSpace& space = UnitBox(3)) const {
    std::string options = GetParam().options == "{}" ? "" : GetParam().options;
    if (!options.empty() && !more.empty()) options += ", ";
    return MakeFrom(GetParam().name, "{" + options + more + "}", space,
                    Minimised(GetParam().objectives), seed);
  }
  Responses Function() const {
    return [n = GetParam().objectives](const Eigen::VectorXd& x) { return Bowls(x, n); };
  }
};

INSTANTIATE_TEST_SUITE_P(All, MetaheuristicTest, testing::ValuesIn(AllMetaheuristics()),
                         [](const auto& test) { return CaseName(test.param); });

TEST_P(MetaheuristicTest, ComesCloseToTheOptimum) {
  const auto optimizer = Make(1);
  const std::vector<Observation> history = RunInBatches(optimizer.get(), Function(), 800);
  ASSERT_EQ(history.size(), 800);
  EXPECT_LT(LowestFirst(history), GetParam().objectives == 1 ? 1e-3 : 3e-2);
  for (std::size_t i = 0; i < history.size(); ++i) {
    EXPECT_EQ(history[i].id, static_cast<std::int64_t>(i));
    EXPECT_GE(history[i].point.minCoeff(), 0);
    EXPECT_LE(history[i].point.maxCoeff(), 1);
  }
}

// The order of telling and the sizes of asking are drawn at random; points must be the same.
TEST_P(MetaheuristicTest, CandidatesDependOnTheSeedAndTheValuesAlone) {
  const auto orderly = Make(5);
  const auto other_seed = Make(6);
  const std::vector<Observation> expected = RunInBatches(orderly.get(), Function(), 150);
  EXPECT_NE(RunInBatches(other_seed.get(), Function(), 1)[0].point, expected[0].point);
  const auto disorderly = Make(5);
  RandomStream random(1);
  std::vector<Observation> untold;
  std::size_t asked = 0;
  while (asked < expected.size()) {
    for (const Candidate& candidate : disorderly->Ask(1 + static_cast<int>(random.Below(7)))) {
      if (asked < expected.size()) {
        EXPECT_EQ(candidate.point, expected[asked].point) << asked;
      }
      EXPECT_EQ(candidate.id, static_cast<std::int64_t>(asked++));
      untold.push_back(Succeeded(candidate, Function()(candidate.point)));
    }
    random.Shuffle(std::span(untold));
    const auto told = static_cast<std::ptrdiff_t>(random.Below(untold.size() + 1));
    disorderly->Tell(std::span(untold).first(static_cast<std::size_t>(told)));
    untold.erase(untold.begin(), untold.begin() + told);
  }
}

TEST_P(MetaheuristicTest, WaitsForTheRestOfABatch) {
  const auto optimizer = Make(1, "population: 12");
  EXPECT_EQ(optimizer->status().phase, Status::Phase::ready);
  std::vector<Candidate> batch = optimizer->Ask(7);
  EXPECT_EQ(batch.size(), 7);
  EXPECT_EQ(optimizer->status().phase, Status::Phase::ready);
  const std::vector<Candidate> rest = optimizer->Ask(100);
  EXPECT_EQ(rest.size(), 5);
  batch.insert(batch.end(), rest.begin(), rest.end());
  EXPECT_TRUE(optimizer->Ask(1).empty());
  EXPECT_EQ(optimizer->status().phase, Status::Phase::waiting);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Observation told = Succeeded(batch[i], Function()(batch[i].point));
    optimizer->Tell(std::span(&told, 1));
    EXPECT_EQ(optimizer->status().phase,
              i + 1 < batch.size() ? Status::Phase::waiting : Status::Phase::ready);
  }
  EXPECT_THAT(optimizer->Ask(1)[0].origin, StartsWith("generation 1"));
  EXPECT_EQ(optimizer->capabilities().asynchronous, GetParam().batches);
}

TEST_P(MetaheuristicTest, FindsTheOptimumBesideFailures) {
  const auto optimizer = Make(2);
  const std::vector<Observation> history = RunInBatches(
      optimizer.get(),
      [&](const Eigen::VectorXd& x) { return x[0] > 0.35 ? Eigen::VectorXd() : Function()(x); },
      600);
  ASSERT_EQ(history.size(), 600);
  EXPECT_LT(LowestFirst(history), GetParam().objectives == 1 ? 3e-3 : 6e-2);
  const auto failed = [](const Observation& o) { return o.failed; };
  EXPECT_LT(std::count_if(history.end() - 200, history.end(), failed), 130);
}

TEST_P(MetaheuristicTest, GoesOnAfterAPopulationThatFailed) {
  const auto optimizer = Make(3, "population: 8");
  const auto all_fail = [](const Eigen::VectorXd&) { return Eigen::VectorXd(); };
  RunInBatches(optimizer.get(), all_fail, 24);
  const std::vector<Candidate> uniform = optimizer->Ask(100);
  ASSERT_EQ(uniform.size(), 8);
  EXPECT_EQ(uniform[0].origin, "random: nothing has succeeded yet");
  std::vector<Observation> told;
  for (const Candidate& candidate : uniform) told.push_back(Failed(candidate));
  told[3] = Succeeded(uniform[3], Function()(uniform[3].point));
  optimizer->Tell(told);
  EXPECT_THAT(optimizer->Ask(1)[0].origin, StartsWith("generation 1"));
  EXPECT_EQ(RunInBatches(optimizer.get(), Function(), 0).size(), 0);
}

// One success among failures, and then failures only: nothing may break or hang.
TEST_P(MetaheuristicTest, SurvivesEndlessFailures) {
  const auto optimizer = Make(4, "population: 8");
  int evaluated = 0;
  const auto responses = [&](const Eigen::VectorXd& x) {
    return evaluated++ == 2 ? Function()(x) : Eigen::VectorXd();
  };
  const std::vector<Observation> history = RunInBatches(optimizer.get(), responses, 300);
  EXPECT_EQ(history.size(), 300);
  for (const Observation& observation : history) EXPECT_TRUE(observation.point.allFinite());
}

TEST_P(MetaheuristicTest, EndsAfterItsGenerations) {
  const auto optimizer = Make(1, "population: 8, generations: 3");
  EXPECT_EQ(RunInBatches(optimizer.get(), Function(), 1000).size(), 8 * (1 + 3));
  EXPECT_EQ(optimizer->status().phase, Status::Phase::finished);
  EXPECT_THAT(optimizer->status().message, HasSubstr("all 3 generations"));
  EXPECT_TRUE(optimizer->Ask(1).empty());
}

// Destruction at every stage: before the first Ask, within a batch, between batches.
TEST_P(MetaheuristicTest, CanBeAbandonedAtAnyMoment) {
  for (int evaluations : {0, 1, 8, 9, 12, 16, 17}) {
    const auto optimizer = Make(1, "population: 8");
    RunInBatches(optimizer.get(), Function(), evaluations);
    optimizer->Ask(evaluations % 3);
  }
}

TEST_P(MetaheuristicTest, IntegersAreSnappedAndFound) {
  SearchSpace space = UnitBox(3);
  space.parameters[1] = {.name = "n", .lower = 1, .upper = 9, .kind = Parameter::Kind::integer};
  const auto optimizer = Make(1, "", space);
  EXPECT_TRUE(optimizer->capabilities().discrete);
  const auto responses = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    EXPECT_EQ(space.Snap(x), x);
    const Eigen::VectorXd values = space.FromUnit(x);
    return Bowls(Eigen::Vector3d(values[0], 0.3 + 0.1 * (values[1] - 7), values[2]),
                 GetParam().objectives);
  };
  const std::vector<Observation> history = RunInBatches(optimizer.get(), responses, 600);
  double best = 1e300;
  double level = 0;
  for (const Observation& o : history) {
    if (o.responses[0] < best) level = space.FromUnit(o.point)[1];
    best = std::min(best, o.responses[0]);
  }
  EXPECT_EQ(level, 7);
}

// Those of pagmo's that know one point at a time leave one of two workers idle once the initial
// population is complete (docs/optimizers.md).
TEST_P(MetaheuristicTest, TwoWorkersAreBusyWithRunsOfEqualLength) {
  const auto optimizer = Make(1);
  int asked = 0;
  int ticks = 0;
  int shared = 0;  // ticks in which both were busy
  for (; asked < 200; ++ticks) {
    std::vector<Observation> running;
    for (int worker = 0; worker < 2; ++worker) {
      for (const Candidate& candidate : optimizer->Ask(1)) {
        running.push_back(Succeeded(candidate, Function()(candidate.point)));
      }
    }
    ASSERT_FALSE(running.empty());
    shared += running.size() == 2 ? 1 : 0;
    asked += static_cast<int>(running.size());
    optimizer->Tell(running);
  }
  if (GetParam().batches) {
    EXPECT_GE(asked / (2.0 * ticks), 0.9);
  } else {
    EXPECT_EQ(asked, ticks + shared);
    EXPECT_LE(asked / (2.0 * ticks), 0.7);
    EXPECT_FALSE(optimizer->capabilities().asynchronous);
  }
}

TEST_P(MetaheuristicTest, RefusesTheWrongNumberOfObjectives) {
  const bool pareto = GetParam().objectives > 1;
  const auto optimizer = Make(1);
  EXPECT_EQ(optimizer->capabilities().pareto, pareto);
  EXPECT_EQ(optimizer->ExplainUnsupported(UnitBox(3), Minimised(pareto ? 2 : 1)), "");
  const Objectives wrong = Minimised(pareto ? 1 : 2);
  EXPECT_THAT(optimizer->ExplainUnsupported(UnitBox(3), wrong),
              AllOf(StartsWith(GetParam().name), HasSubstr("use bayesian"),
                    HasSubstr(pareto ? "genetic" : "nsga2")));
  EXPECT_THAT(optimizer->ExplainUnsupported(SearchSpace{}, wrong), HasSubstr("no parameter"));
  EXPECT_THAT(optimizer->ExplainUnsupported(UnitBox(3), {}), HasSubstr("no observed response"));
  const auto unable = MakeFrom(GetParam().name, GetParam().options, UnitBox(3), wrong, 1);
  EXPECT_TRUE(unable->Ask(1).empty());
  EXPECT_EQ(unable->status().phase, Status::Phase::finished);
}

TEST_P(MetaheuristicTest, CategoriesAreForOwnGeneticOperatorsOnly) {
  SearchSpace space = UnitBox(2);
  space.parameters[1] = {.name = "law",
                         .upper = 2,
                         .kind = Parameter::Kind::categorical,
                         .categories = {"a", "b", "c"}};
  const auto optimizer = Make(1, "", space);
  const std::string reason = optimizer->ExplainUnsupported(space, Minimised(GetParam().objectives));
  if (GetParam().options == "{}" && (GetParam().name == "genetic" || GetParam().name == "moead")) {
    EXPECT_EQ(reason, "");
  } else {
    EXPECT_THAT(reason, AllOf(HasSubstr("law"), HasSubstr("implementation: own")));
  }
}

TEST_P(MetaheuristicTest, OptionsAreReadAsTheyAreWritten) {
  const std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory(GetParam().name);
  const auto serialize = [&](OptimizerFactory& f) {
    return [&f](Archive& archive) { f.Serialize(archive, UnitBox(3)); };
  };
  ReadYaml("{population: 24, generations: 5, initial_design: {name: sobol, points: 6}}",
           "study.yaml", serialize(*factory));
  ReadYaml(GetParam().options, "study.yaml", serialize(*factory));
  const std::string written = WriteYaml(serialize(*factory));
  EXPECT_THAT(written, AllOf(HasSubstr("population: 24"), HasSubstr("generations: 5")));
  const std::unique_ptr<OptimizerFactory> copy = MakeOptimizerFactory(GetParam().name);
  ReadYaml(written, "study.yaml", serialize(*copy));
  EXPECT_EQ(WriteYaml(serialize(*copy)), written);
}

// Telling again what is known by more replicates replaces it; the search goes on.
TEST_P(MetaheuristicTest, MayBeToldAgain) {
  const auto optimizer = Make(1, "population: 8");
  std::vector<Observation> history = RunInBatches(optimizer.get(), Function(), 20);
  for (Observation& observation : history) observation.responses.array() += 0.1;
  optimizer->Tell(history);
  EXPECT_EQ(RunInBatches(optimizer.get(), Function(), 100).size(), 100);
}

TEST_P(MetaheuristicTest, RefusesWhatItDidNotAskFor) {
  const auto optimizer = Make(1);
  const Candidate candidate = optimizer->Ask(1)[0];
  Observation observation = Succeeded(candidate, Function()(candidate.point));
  observation.id = 1;
  EXPECT_THROW(optimizer->Tell(std::span(&observation, 1)), std::invalid_argument);
  observation.id = 0;
  observation.responses.conservativeResize(5);
  EXPECT_THROW(optimizer->Tell(std::span(&observation, 1)), std::invalid_argument);
}

TEST(MetaheuristicOptionsTest, MistakesAreErrorsWithTheirPlace) {
  const auto error = [](const std::string& name, const std::string& options) -> std::string {
    try {
      MakeFrom(name, options, UnitBox(2), Minimised(1), 1);
    } catch (const InputError& mistake) {
      return mistake.what();
    }
    return "";
  };
  EXPECT_THAT(error("genetic", "poplation: 8"),
              AllOf(HasSubstr("study.yaml:1:1"), HasSubstr("did you mean 'population'?")));
  EXPECT_THAT(error("genetic", "population: 3"), HasSubstr("population: must be at least 4"));
  EXPECT_THAT(error("nsga2", "population: 10"),
              HasSubstr("population: must be a multiple of 4 and at least 8"));
  EXPECT_THAT(error("cma_es", "{implementation: pagmo, smallest_step: 1e-3}"),
              HasSubstr("unknown key 'smallest_step'"));
  EXPECT_THAT(error("cma_es", "initial_step: 0"), HasSubstr("initial_step"));
  EXPECT_THAT(error("moead", "implementation: pygmo"), HasSubstr("did you mean 'pagmo'?"));
  EXPECT_THAT(error("particle_swarm", "inertia: 1.5"), HasSubstr("inertia"));
  EXPECT_THAT(error("ant_colony", "{kernels: 30, population: 20}"),
              HasSubstr("population: must be at least 30"));
  EXPECT_THAT(error("moead", "neighbours: 1"), HasSubstr("must be 0 or at least 2"));
  EXPECT_THAT(error("genetic", "initial_design: sobel"), HasSubstr("did you mean 'sobol'?"));
}

TEST(InitialPopulationTest, IsASobolDesignByDefault) {
  const auto optimizer = MakeFrom("genetic", "population: 8", UnitBox(2), Minimised(1), 3);
  const std::vector<Candidate> asked = optimizer->Ask(100);
  const Eigen::MatrixXd sobol = SobolPoints(8, 2, 3);
  ASSERT_EQ(asked.size(), 8);
  for (Eigen::Index i = 0; i < 8; ++i) {
    EXPECT_EQ(asked[static_cast<std::size_t>(i)].point, sobol.row(i).transpose());
  }
  EXPECT_EQ(asked[7].origin, "initial design: point 8");
}

TEST(InitialPopulationTest, ASmallDesignIsFilledUp) {
  const auto optimizer = MakeFrom("genetic", "{population: 8, initial_design: corners_and_centre}",
                                  UnitBox(2), Minimised(1), 3);
  const std::vector<Candidate> asked = optimizer->Ask(100);
  ASSERT_EQ(asked.size(), 8);
  EXPECT_EQ(asked[3].point, Eigen::Vector2d(1, 1));
  EXPECT_EQ(asked[3].origin, "initial design: corner 4");
  EXPECT_EQ(asked[5].origin, "initial population: random");
}

// A strategy of tiny steps shows where it starts.
std::unique_ptr<Optimizer> StartingAtTheBest(const std::string& more) {
  return MakeFrom("cma_es", "{initial_step: 1e-6, population: 6" + more + "}", UnitBox(2),
                  Minimised(1), 3);
}

TEST(InitialPopulationTest, OfALargeDesignTheBestGoOn) {
  const auto optimizer = StartingAtTheBest(", initial_design: {name: grid, levels: 4}");
  const auto responses = [](const Eigen::VectorXd& x) { return Bowls(x, 1); };
  EXPECT_EQ(RunInBatches(optimizer.get(), responses, 16).size(), 16);
  EXPECT_LT((optimizer->Ask(1)[0].point - Eigen::Vector2d(1.0 / 3, 1.0 / 3)).norm(), 1e-4);
}

TEST(InitialPopulationTest, KnownPointsMayEnter) {
  const auto optimizer = StartingAtTheBest("");
  const Observation known{
      .id = -1, .point = Eigen::Vector2d(0.9, 0.8), .responses = Eigen::VectorXd::Constant(1, -1)};
  optimizer->Tell(std::span(&known, 1));
  RunInBatches(
      optimizer.get(), [](const Eigen::VectorXd& x) { return Bowls(x, 1); }, 6);
  EXPECT_LT((optimizer->Ask(1)[0].point - known.point).norm(), 1e-4);
}

TEST(InitialPopulationTest, APartialFailureIsNoBest) {
  Objectives joint = JointTargets({0, 0}, 1);
  const auto optimizer =
      MakeFrom("cma_es", "{initial_step: 1e-6, population: 6}", UnitBox(2), joint, 3);
  const std::vector<Candidate> asked = optimizer->Ask(6);
  std::vector<Observation> told;
  for (const Candidate& candidate : asked) {
    told.push_back(Succeeded(candidate, Eigen::Vector2d(2, 2)));
  }
  told[1].responses = Eigen::Vector2d(0, kNaN);
  told[4].responses = Eigen::Vector2d(1, 1);
  optimizer->Tell(told);
  EXPECT_LT((optimizer->Ask(1)[0].point - asked[4].point).norm(), 1e-4);
}

}  // namespace
}  // namespace powdercal
