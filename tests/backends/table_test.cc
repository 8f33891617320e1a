#include "backends/table/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <thread>

#include "core/errors.h"

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kHeader =
    "cohesion_energy_density [kJ/m3],rolling_friction,consolidation.void_ratio,shear.cohesion "
    "[kPa]\n";

// void_ratio = 0.5 + k/(100 kJ/m3) + 0.2 mu_r on a square grid.
double TrueVoidRatio(double k, double mu) { return 0.5 + k / 1e5 + 0.2 * mu; }

std::string GridCsv(int side = 5) {
  std::string text = kHeader;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double k = 1e5 * i / (side - 1);
      const double mu = 0.7 * j / (side - 1);
      text += std::to_string(k / 1e3) + "," + std::to_string(mu) + "," +
              std::to_string(TrueVoidRatio(k, mu)) + "," + std::to_string(mu) + "\n";
    }
  }
  return text;
}

class TableBackendTest : public ::testing::Test {
 protected:
  TableBackendTest() {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("table_test_" + std::to_string(::getpid()) + "_" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    problem_.base_folder = folder_;
    problem_.parameters = {{"cohesion_energy_density", "J/m3", 0, 1e5},
                           {"rolling_friction", "1", 0, 0.7}};
    problem_.responses = {{"consolidation.void_ratio", "1"}};
    program_.experiment = "consolidation";
    program_.parameters = {{"cohesion_energy_density", 4e4}, {"rolling_friction", 0.3}};
  }
  ~TableBackendTest() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& text) { std::ofstream(folder_ / "t.csv") << text; }

  std::string ErrorOf() {
    TableBackend backend({.file = "t.csv"});
    try {
      backend.Prepare(problem_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
  BackendProblem problem_;
  Program program_;
};

TEST_F(TableBackendTest, ReportsTheSurrogateAndSaysSo) {
  Write(GridCsv());
  TableBackend backend({.file = "t.csv"});
  EXPECT_THAT(backend.Prepare(problem_), IsEmpty());
  EXPECT_FALSE(backend.simulates());
  EXPECT_TRUE(backend.availability().available);
  EXPECT_EQ(backend.ExplainUnsupported(program_), "");
  const Trace trace = backend.Run(program_, {});
  EXPECT_TRUE(trace.outcome.ok());
  EXPECT_EQ(trace.diagnostics.law, "none: gaussian_process of t.csv; no simulation was run");
  ASSERT_EQ(trace.reported.size(), 1u);
  EXPECT_NEAR(trace.reported.at("void_ratio").value, TrueVoidRatio(4e4, 0.3), 0.005);
  EXPECT_EQ(trace.reported.at("void_ratio").variance, 0);
  EXPECT_GE(trace.diagnostics.figures.at("void_ratio.surrogate_sd"), 0);
  EXPECT_TRUE(trace.moments.empty());
}

TEST_F(TableBackendTest, ReportsTheResponsesOfTheProgramsExperimentInSi) {
  Write(GridCsv());
  problem_.responses.push_back({"shear.cohesion", "Pa"});
  TableBackend backend({.file = "t.csv"});
  backend.Prepare(problem_);
  program_.experiment = "shear";
  const Trace trace = backend.Run(program_, {});
  ASSERT_EQ(trace.reported.size(), 1u);
  EXPECT_NEAR(trace.reported.at("cohesion").value, 300, 5);
}

TEST_F(TableBackendTest, ReadsItsOptionsFromTheStudy) {
  Write(GridCsv());
  TableBackend backend;
  ReadYaml("file: t.csv\nsurrogate: gaussian_process\n", "study.yaml",
           [&](Archive& archive) { backend.Serialize(archive); });
  backend.Prepare(problem_);
  EXPECT_EQ(backend.ExplainUnsupported(program_), "");
  EXPECT_EQ(WriteYaml([&](Archive& archive) { backend.Serialize(archive); }),
            "file: t.csv\nsurrogate: gaussian_process\n");
}

TEST_F(TableBackendTest, AnswersFromTheSurrogateThatTheStudyNames) {
  Write(GridCsv());
  TableBackend forest({.file = "t.csv", .surrogate = "random_forest"});
  TableBackend process({.file = "t.csv"});
  forest.Prepare(problem_);
  process.Prepare(problem_);
  EXPECT_EQ(forest.Describe(), "consolidation.void_ratio by random_forest");
  EXPECT_NE(forest.Fingerprint(), process.Fingerprint());
  const Trace trace = forest.Run(program_, {});
  EXPECT_EQ(trace.diagnostics.law, "none: random_forest of t.csv; no simulation was run");
  EXPECT_NEAR(trace.reported.at("void_ratio").value, TrueVoidRatio(4e4, 0.3), 0.2);
}

TEST_F(TableBackendTest, BestIsChosenForEachResponse) {
  Write(GridCsv(3));
  problem_.responses.push_back({"shear.cohesion", "Pa"});
  TableBackend backend({.file = "t.csv", .surrogate = TableBackend::kBest});
  EXPECT_EQ(backend.Describe(), "");
  backend.Prepare(problem_);
  // The table is linear in its parameters.
  EXPECT_EQ(backend.Describe(), "consolidation.void_ratio by ridge, shear.cohesion by ridge");
  const Trace trace = backend.Run(program_, {});
  EXPECT_NEAR(trace.reported.at("void_ratio").value, TrueVoidRatio(4e4, 0.3), 1e-4);
  EXPECT_EQ(trace.diagnostics.law, "none: ridge of t.csv; no simulation was run");
}

TEST_F(TableBackendTest, NeedsAFileAndAKnownSurrogate) {
  const auto error = [](const std::string& yaml) -> std::string {
    TableBackend backend;
    try {
      ReadYaml(yaml, "study.yaml", [&](Archive& archive) { backend.Serialize(archive); });
    } catch (const InputError& problem) {
      return problem.what();
    }
    return "no error";
  };
  EXPECT_THAT(error("surrogate: gaussian_process\n"), HasSubstr("missing key 'file'"));
  EXPECT_THAT(error("file: t.csv\nsurrogate: gausian_process\n"),
              AllOf(HasSubstr("study.yaml:2"), HasSubstr("did you mean 'gaussian_process'?")));
}

TEST_F(TableBackendTest, AMissingFileIsAnErrorInTheStudy) {
  TableBackend backend;
  ReadYaml("surrogate: gaussian_process\nfile: no_such.csv\n", "study.yaml",
           [&](Archive& archive) { backend.Serialize(archive); });
  try {
    backend.Prepare(problem_);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("study.yaml:2"), HasSubstr("file"),
                                    HasSubstr((folder_ / "no_such.csv").string())));
  }
}

TEST_F(TableBackendTest, ABadRowIsAnErrorInTheTable) {
  Write(std::string(kHeader) + "1,0.1,0.5,1\n2,zero,0.5,1\n3,0.3,0.5,1\n");
  EXPECT_THAT(ErrorOf(), AllOf(HasSubstr("t.csv:3"), HasSubstr("zero")));
}

TEST_F(TableBackendTest, NeedsThreeRows) {
  Write(std::string(kHeader) + "1,0.1,0.5,1\n2,0.2,0.6,1\n");
  EXPECT_THAT(ErrorOf(), AllOf(HasSubstr("t.csv"), HasSubstr("2 rows"), HasSubstr("at least 3")));
}

TEST_F(TableBackendTest, NamesAMissingParameterColumn) {
  Write(GridCsv());
  problem_.parameters[1].name = "roling_friction";
  EXPECT_THAT(ErrorOf(), AllOf(HasSubstr("t.csv"), HasSubstr("roling_friction"),
                               HasSubstr("did you mean 'rolling_friction'?")));
}

TEST_F(TableBackendTest, NamesAMissingResponseColumn) {
  Write(GridCsv());
  problem_.responses = {{"consolidation.void_ratios", "1"}};
  EXPECT_THAT(ErrorOf(), HasSubstr("did you mean 'consolidation.void_ratio'?"));
}

TEST_F(TableBackendTest, RefusesAColumnOfAnotherDimension) {
  Write(GridCsv());
  problem_.parameters[0].unit = "J/m2";
  EXPECT_THAT(ErrorOf(), HasSubstr("cohesion_energy_density"));
  EXPECT_NE(ErrorOf(), "no error");
}

TEST_F(TableBackendTest, WarnsOfExtrapolationAndOfIgnoredInputs) {
  Write(GridCsv());
  problem_.parameters[0].upper = 1.05e5;  // within a tenth of the data's range
  TableBackend near({.file = "t.csv"});
  EXPECT_THAT(near.Prepare(problem_), IsEmpty());
  problem_.parameters[0].upper = 2e5;
  problem_.parameters.pop_back();
  TableBackend far({.file = "t.csv"});
  EXPECT_THAT(far.Prepare(problem_),
              ElementsAre(AllOf(HasSubstr("cohesion_energy_density"), HasSubstr("2e+05 J/m3"),
                                HasSubstr("extrapolates")),
                          AllOf(HasSubstr("rolling_friction"), HasSubstr("varies"))));
}

TEST_F(TableBackendTest, ExplainsProgramsThatItCannotAnswer) {
  Write(GridCsv());
  TableBackend backend({.file = "t.csv"});
  EXPECT_THAT(backend.ExplainUnsupported(program_), HasSubstr("not been read"));
  backend.Prepare(problem_);
  Program other = program_;
  other.experiment = "shear";
  EXPECT_THAT(backend.ExplainUnsupported(other), HasSubstr("'shear'"));
  EXPECT_EQ(backend.Run(other, {}).outcome.reason, Reason::unsupported);
  other = program_;
  other.parameters.erase("rolling_friction");
  EXPECT_THAT(backend.ExplainUnsupported(other), HasSubstr("'rolling_friction'"));
}

TEST_F(TableBackendTest, TheFingerprintSeesFileAndBox) {
  const auto fingerprint = [&] {
    TableBackend backend({.file = "t.csv"});
    backend.Prepare(problem_);
    return backend.Fingerprint();
  };
  Write(GridCsv());
  const std::string first = fingerprint();
  EXPECT_EQ(first.size(), 64u);
  EXPECT_EQ(fingerprint(), first);
  problem_.parameters[0].upper = 1.1e5;
  EXPECT_NE(fingerprint(), first);
  problem_.parameters[0].upper = 1e5;
  Write(GridCsv() + "# one more line\n");
  EXPECT_NE(fingerprint(), first);
}

TEST_F(TableBackendTest, ManyThreadsGetTheSameAnswer) {
  Write(GridCsv());
  TableBackend backend({.file = "t.csv"});
  backend.Prepare(problem_);
  const double expected = backend.Run(program_, {}).reported.at("void_ratio").value;
  std::vector<double> answers(4, 0);
  {
    std::vector<std::jthread> threads;
    for (double& answer : answers) {
      threads.emplace_back([&backend, &answer, this] {
        for (int i = 0; i < 50; ++i)
          answer = backend.Run(program_, {}).reported["void_ratio"].value;
      });
    }
  }
  for (const double answer : answers) EXPECT_EQ(answer, expected);
}

}  // namespace
}  // namespace powdercal
