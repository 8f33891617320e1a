#include "backends/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/portable_math.h"
#include "tests/backends/sample_program.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

constexpr SizeDistribution kNormal{SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
constexpr SizeDistribution kLognormal{SizeDistribution::Kind::lognormal, 29e-6, 12e-6, 15e-6,
                                      60e-6};
constexpr SizeDistribution kUpperTail{SizeDistribution::Kind::normal, 10e-6, 2e-6, 15e-6, 30e-6};

std::string ErrorOf(const nlohmann::json& json) {
  try {
    Program::FromJson(json);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PortableMath, AgreesWithTheLibrary) {
  for (double x = -700; x < 709; x += 0.31) {
    EXPECT_NEAR(PortableExp(x) / std::exp(x), 1, 5e-16) << x;
  }
  EXPECT_EQ(PortableExp(0), 1);
  EXPECT_EQ(PortableExp(-1000), 0);
  EXPECT_EQ(PortableExp(1000), std::numeric_limits<double>::infinity());
  for (double z = -8; z < 8; z += 0.013) {
    EXPECT_NEAR(PortableNormalCdf(z) / (0.5 * std::erfc(-z / std::numbers::sqrt2)), 1, 3e-14) << z;
  }
}

TEST(ProgramJson, ReadsBackEveryMember) {
  const Program program = SampleProgram();
  const nlohmann::json json = program.ToJson();
  const Program back = Program::FromJson(nlohmann::json::parse(json.dump()));
  EXPECT_EQ(back.ToJson(), json);
  EXPECT_EQ(back.Hash(), program.Hash());
  EXPECT_EQ(back.particles.seed, program.particles.seed);
  EXPECT_EQ(back.law.cohesion, ContactLaw::Cohesion::sjkr2);
  EXPECT_EQ(back.domain.boundaries[1], Boundary::open);
  ASSERT_EQ(back.stages.size(), 6u);
  EXPECT_EQ(std::get<Servo>(back.stages[2]).stress, 900);
  EXPECT_EQ(std::get<Advance>(back.stages[4]).motions[1].spin, (Vector3{4, 5, 6}));
  EXPECT_EQ(std::get<Deform>(back.stages[5]).edges[2].kind, EdgeControl::Kind::stress);
  EXPECT_EQ(back.walls[1].axis, 1);
  EXPECT_EQ(back.meshes[0].triangles[1], (std::array{1, 3, 2}));
  EXPECT_EQ(back.groups[0].ids, (std::vector<std::int64_t>{1, 2, 5}));
  EXPECT_FALSE(back.particles.packing.has_value());
}

TEST(ProgramJson, HoldsExplicitPackings) {
  Program program = SampleProgram();
  program.particles.packing = {{7, 1.5e-5, {0.1, 0.2, 1.0 / 3}, {1, 2, 3}, {4, 5, 6}},
                               {8, 1e-5, {}, {}, {}}};
  const Program back = Program::FromJson(program.ToJson());
  ASSERT_TRUE(back.particles.packing.has_value());
  ASSERT_EQ(back.particles.packing->size(), 2u);
  const Sphere& sphere = back.particles.packing->front();
  EXPECT_EQ(sphere.id, 7);
  EXPECT_EQ(sphere.position[2], 1.0 / 3);
  EXPECT_EQ(sphere.spin, (Vector3{4, 5, 6}));
  EXPECT_NE(program.Hash(), SampleProgram().Hash());
}

TEST(ProgramJson, WritesContactHistoriesAsArrays) {
  Program program;
  program.particles.contacts = {{7, -2, {1, 2, 3}, {4, 5, 6}}};
  const nlohmann::json json = program.ToJson();
  EXPECT_EQ(json["particles"]["contacts"].dump(), "[[7,-2,1.0,2.0,3.0,4.0,5.0,6.0]]");
  const Program back = Program::FromJson(json);
  ASSERT_EQ(back.particles.contacts.size(), 1u);
  EXPECT_EQ(back.particles.contacts[0].j, -2);
  EXPECT_EQ(back.particles.contacts[0].rolling, (Vector3{4, 5, 6}));
}

TEST(Stages, MomentsAreNamedByTheStageOrByItsOwnName) {
  EXPECT_EQ(MomentName(Settle{}), "settle");
  EXPECT_EQ(MomentName(Advance{}), "advance");
  EXPECT_EQ(MomentName(Advance{.name = "sweep"}), "sweep");
  EXPECT_EQ(MomentName(Deform{.name = "shear"}), "shear");
  EXPECT_EQ(StageName(Deform{.name = "shear"}), "deform");
}

// The hash is the key of every ledger's cache: change it only on purpose.
TEST(ProgramHash, IsStable) {
  EXPECT_EQ(SampleProgram().Hash(),
            "70bc2566c1d0b31f7b81fcd6fd427cb59a8c92a1756b867578af5605abb4549c");
}

TEST(ProgramHash, SeesEveryLeafOfTheSerialisation) {
  const nlohmann::json original = SampleProgram().ToJson();
  const nlohmann::json flat = original.flatten();
  int changed = 0;
  for (const auto& [path, value] : flat.items()) {
    if (!value.is_number_float()) continue;
    nlohmann::json copy = flat;
    copy[path] = value.get<double>() * (1 + 1e-15) + 1e-300;
    EXPECT_NE(Program::FromJson(copy.unflatten()).Hash(), SampleProgram().Hash()) << path;
    ++changed;
  }
  EXPECT_GT(changed, 100);
}

TEST(ProgramHash, NegativeZeroIsZero) {
  Program program = SampleProgram();
  const std::string hash = program.Hash();
  ASSERT_EQ(program.domain.lower[2], 0);
  program.domain.lower[2] = -0.0;
  ASSERT_EQ(program.meshes[0].vertices[0][0], 0);
  program.meshes[0].vertices[0][0] = -0.0;
  EXPECT_EQ(program.Hash(), hash);
}

TEST(ProgramJson, ExplainsBadInput) {
  nlohmann::json json = SampleProgram().ToJson();
  json["law"]["cohesion"] = "sjkr";
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("law.cohesion"), HasSubstr("did you mean 'sjkr2'?")));
  json = SampleProgram().ToJson();
  json.erase("time_step");
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("time_step"), HasSubstr("missing")));
  json = SampleProgram().ToJson();
  json["stages"][1]["max_durations"] = 1;
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("stages[1]"), HasSubstr("max_duration'?")));
  json = SampleProgram().ToJson();
  json["stages"][0]["stage"] = "inserts";
  EXPECT_THAT(ErrorOf(json), HasSubstr("unknown stage 'inserts'"));
  json = SampleProgram().ToJson();
  json["stages"][5]["edges"][0]["kind"] = "pressure";
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("stages[5].edges[0].kind"), HasSubstr("strain_rate")));
  json = SampleProgram().ToJson();
  json["particles"]["contacts"][1].erase(7);
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("particles.contacts[1]"), HasSubstr("array of 8")));
  json = SampleProgram().ToJson();
  json["particles"]["count"] = 10.5;
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("particles.count"), HasSubstr("integer")));
  json["particles"]["count"] = std::int64_t{1} << 40;
  EXPECT_THAT(ErrorOf(json), HasSubstr("out of range"));
}

TEST(ContactLaw, ToStringNamesTheChoices) {
  ContactLaw law;
  EXPECT_EQ(law.ToString(), "hertz + history (displacement), limit_force off");
  law.cohesion = ContactLaw::Cohesion::sjkr2;
  law.rolling = ContactLaw::Rolling::epsd2;
  EXPECT_EQ(law.ToString(),
            "hertz + history (displacement) + sjkr2 + epsd2 with torsion, limit_force off");
  law.tangential = ContactLaw::Tangential::no_history;
  law.limit_force = true;
  EXPECT_EQ(law.ToString(), "hertz + no_history + sjkr2 + epsd2 with torsion, limit_force on");
  law.tangential_reduce = true;
  EXPECT_EQ(
      law.ToString(),
      "hertz + no_history + sjkr2 + epsd2 with torsion, limit_force on, tangential_reduce on");
}

// Programs from before there was a choice keep their hashes.
TEST(ProgramJson, TangentialReduceIsWrittenWhereItIsOn) {
  Program program = SampleProgram();
  EXPECT_FALSE(program.ToJson()["law"].contains("tangential_reduce"));
  const std::string hash = program.Hash();
  program.law.tangential_reduce = true;
  EXPECT_NE(program.Hash(), hash);
  EXPECT_TRUE(Program::FromJson(program.ToJson()).law.tangential_reduce);
  nlohmann::json json = program.ToJson();
  json["law"]["tangential_reduce"] = false;
  EXPECT_EQ(Program::FromJson(json).Hash(), hash);
  json["law"]["tangential_reduce"] = "on";
  EXPECT_THAT(ErrorOf(json), AllOf(HasSubstr("law.tangential_reduce"), HasSubstr("true or false")));
}

// physics.md §3: dt = 1e-6 s is 31 % of T_R at 29 um and 90 % at 10 um, with E = 5 MPa.
TEST(RayleighTime, AgreesWithTheStudiedCases) {
  EXPECT_NEAR(1e-6 / RayleighTime(14.5e-6, 8220, 5e6, 0.3), 0.31, 0.005);
  EXPECT_NEAR(1e-6 / RayleighTime(5e-6, 8220, 5e6, 0.3), 0.90, 0.01);
}

class Distributions : public ::testing::TestWithParam<SizeDistribution> {};

TEST_P(Distributions, QuantilesInvertTheCumulativeFraction) {
  const SizeDistribution& sizes = GetParam();
  ASSERT_EQ(sizes.ExplainInvalid(), "");
  const auto cumulative = [&](double d) {
    double mean = sizes.mean;
    double sd = sizes.standard_deviation;
    if (sizes.kind == SizeDistribution::Kind::lognormal) {
      const double variance = std::log(1 + sd * sd / (mean * mean));
      mean = std::log(mean) - variance / 2;
      sd = std::sqrt(variance);
      d = std::log(d);
    }
    return 0.5 * std::erfc(-(d - mean) / sd / std::numbers::sqrt2);
  };
  const double low = cumulative(sizes.min);
  const double high = cumulative(sizes.max);
  for (double p = 0.001; p < 1; p += 0.037) {
    EXPECT_NEAR((cumulative(sizes.Quantile(p)) - low) / (high - low), p, 1e-10) << p;
  }
  EXPECT_EQ(sizes.Quantile(0), sizes.min);
  EXPECT_EQ(sizes.Quantile(1), sizes.max);
}

// E d^n is the integral of Quantile(p)^n over p; a long tail slows the midpoint rule down.
TEST_P(Distributions, MomentsAreThoseOfTheQuantiles) {
  const SizeDistribution& sizes = GetParam();
  constexpr int kSteps = 200000;
  for (int power = 1; power <= 3; ++power) {
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += std::pow(sizes.Quantile((i + 0.5) / kSteps), power);
    EXPECT_NEAR(sizes.Moment(power) / (sum / kSteps), 1, 1e-6) << power;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Distributions, ::testing::Values(kNormal, kLognormal, kUpperTail));

TEST(SizeDistribution, LognormalMeanAndDeviationAreThoseOfTheDiameter) {
  const SizeDistribution wide{SizeDistribution::Kind::lognormal, 30e-6, 10e-6, 1e-9, 1};
  EXPECT_NEAR(wide.Moment(1) / 30e-6, 1, 1e-12);
  EXPECT_NEAR(std::sqrt(wide.Moment(2) - wide.Moment(1) * wide.Moment(1)) / 10e-6, 1, 1e-9);
}

TEST(SizeDistribution, MonodisperseHasOneDiameter) {
  const SizeDistribution sizes{SizeDistribution::Kind::monodisperse, 29e-6};
  EXPECT_EQ(sizes.ExplainInvalid(), "");
  EXPECT_EQ(sizes.Quantile(0.3), 29e-6);
  EXPECT_DOUBLE_EQ(sizes.Moment(3), 29e-6 * 29e-6 * 29e-6);
}

TEST(SizeDistribution, ExplainsWhatIsInvalid) {
  SizeDistribution sizes = kNormal;
  sizes.max = 10e-6;
  EXPECT_THAT(sizes.ExplainInvalid(), HasSubstr("not above the smallest"));
  sizes = kNormal;
  sizes.standard_deviation = 0;
  EXPECT_THAT(sizes.ExplainInvalid(), HasSubstr("standard deviation"));
  sizes = kNormal;
  sizes.min = 80e-6;
  sizes.max = 90e-6;
  EXPECT_THAT(sizes.ExplainInvalid(), HasSubstr("millionth"));
}

}  // namespace
}  // namespace powdercal
