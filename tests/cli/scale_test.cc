#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

Streams Scale(const TemporaryFolder& folder, const std::string& variables,
              std::vector<std::string> more = {}) {
  WriteFileAtomically(folder / "v.yaml", variables);
  std::vector<std::string> arguments = {"scale", "--variables", "v.yaml"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return PowdercalStreams(arguments, folder.path());
}

constexpr const char* kDrag =
    "variables: {F: N, rho: kg/m3, V: m/s, D: m, mu: Pa s}\nprefer: [rho, V, D]\n";

TEST(ScaleVariables, PrintsTheGroups) {
  const TemporaryFolder folder;
  const Streams result = Scale(folder, kDrag);
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(result.error, "");
  EXPECT_THAT(result.output, HasSubstr("rank 3: 2 groups"));
  EXPECT_THAT(result.output, HasSubstr("F / (D^2 V^2 rho)"));
}

TEST(ScaleVariables, JsonHoldsExponentsByName) {
  const TemporaryFolder folder;
  const Streams result = Scale(folder, kDrag, {"--json"});
  EXPECT_EQ(result.exit_status, 0);
  const json document = json::parse(result.output);
  const json expected = {{{"F", 1}, {"rho", -1}, {"V", -2}, {"D", -2}},
                         {{"mu", 1}, {"rho", -1}, {"V", -1}, {"D", -1}}};
  EXPECT_EQ(document["groups"], expected);
  EXPECT_EQ(document["rank"], 3);
  EXPECT_EQ(document["repeating"], json({"rho", "V", "D"}));
}

TEST(ScaleVariables, NoGroupIsAnEmptyList) {
  const TemporaryFolder folder;
  const Streams result = Scale(folder, "variables: {L: m, t: s}\n", {"--json"});
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(json::parse(result.output)["groups"], json::array());
}

TEST(ScaleVariables, BadFilesAreRefusedWithPlace) {
  const TemporaryFolder folder;
  Streams result = Scale(folder, "variables:\n  F: N\n  V: m/sec2x\n");
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("v.yaml:3:6: variables.V.unit: 'm/sec2x' is not a unit"));
  result = Scale(folder, "variables: {F: N, Velocity: m/s}\nprefer: [velocity]\n");
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("v.yaml:2:10: prefer: unknown variable 'velocity'"));
  EXPECT_THAT(result.error, HasSubstr("did you mean 'Velocity'?"));
  result = PowdercalStreams({"scale", "--variables", "absent.yaml"}, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("absent.yaml"));
}

TEST(ScaleStudy, PrintsConditionsGroupsCohesionAndCost) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams({"scale", "quickstart"}, folder.path());
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_EQ(result.error, "");
  for (const char* piece :
       {"# scaling 'given'", "# consolidation at k = 3162 J/m3", "Young's modulus", "sigma/E",
        "violated: sigma/E: the simulated particles are 4000 times too soft", "dt/T_R",
        "servo gain", "stands for a powder with a surface energy of", "rigid_limit, kappa 1000",
        "given (this study)"}) {
    EXPECT_THAT(result.output, HasSubstr(piece));
  }
  EXPECT_THAT(result.output, ::testing::Not(HasSubstr("\x1b")));
  EXPECT_TRUE(Listing(folder.path()).empty());
}

TEST(ScaleStudy, SaysInPlainWordsWhatThePapersScalingDoes) {
  const TemporaryFolder folder;
  const std::filesystem::path cases =
      std::filesystem::path(POWDERCAL_SOURCE_DIR) / "tests/studies/paper_cases";
  const Streams result =
      PowdercalStreams({"scale", (cases / "section_4_1.yaml").string()}, folder.path());
  EXPECT_EQ(result.exit_status, 0);
  EXPECT_THAT(result.output, HasSubstr("self-weight exceeds the applied stress 572 times"));
  EXPECT_THAT(result.output, HasSubstr("cohesion is 5.6e5 times too strong against the load"));
}

TEST(ScaleStudy, JsonHoldsAllOfIt) {
  const TemporaryFolder folder;
  const Streams result =
      PowdercalStreams({"scale", "quickstart", "-p", "k=47500", "--json"}, folder.path());
  EXPECT_EQ(result.exit_status, 0);
  const json document = json::parse(result.output);
  EXPECT_EQ(document["mode"], "given");
  EXPECT_EQ(document["parameters"]["cohesion_energy_density"], 47500);
  const json& experiment = document["experiments"][0];
  EXPECT_EQ(experiment["experiment"], "consolidation");
  EXPECT_EQ(experiment["laboratory"]["stress"], 9000);
  EXPECT_EQ(experiment["simulation"]["stress"], 900);
  EXPECT_GT(experiment["effective_surface_energy"]["value"], 1e-3);
  EXPECT_EQ(experiment["groups"][0]["symbol"], "sigma/E");
  EXPECT_EQ(experiment["groups"][0]["verdict"], "violated");
  EXPECT_GT(document["modes"].size(), 4u);
  EXPECT_EQ(document["modes"][0]["own"], true);
}

TEST(ScaleStudy, EitherAStudyOrVariables) {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"scale"}, {"scale", "quickstart", "--variables", "v.yaml"}}) {
    const Streams result = PowdercalStreams(arguments, folder.path());
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_THAT(result.error, HasSubstr("either a STUDY or --variables FILE"));
  }
}

TEST(ScaleStudy, RefusesWhatCannotBeScaled) {
  const TemporaryFolder folder;
  const Streams result = PowdercalStreams(
      {"scale", "quickstart", "--set", "scaling.young_modulus=5 TPa"}, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_EQ(result.output, "");
  EXPECT_THAT(result.error, HasSubstr("above the powder's (200 GPa)"));
}

// A powder so soft that a few seconds of simulation do.
constexpr const char* kSoftPowder = R"(
study: soft
material:
  density: 8220 kg/m3
  young_modulus: 20 MPa
  poisson_ratio: 0.3
  restitution: 0.4
  friction: {particle: 0.3, wall: 0.3}
  surface_energy: 0.5 mJ/m2
  sizes: {distribution: normal, mean: 29 um, sd: 6 um, min: 12.5 um, max: 37.5 um}
contact_law: {cohesion: sjkr2, rolling: epsd2}
parameters:
  cohesion_energy_density: {range: [1e2, 1e5], unit: J/m3}
  rolling_friction: {range: [0.1, 0.5]}
scaling: {mode: given, young_modulus: 5 MPa, stress_ratio: 0.5}
experiments:
  - consolidation: {stress: 9 kPa, observed: {void_ratio: {value: 0.8, sd: 0.01}}}
)";

TEST(ScaleCollapse, SimulatesTheModesAndWritesThePlots) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "s.yaml", kSoftPowder);
  const Streams result = PowdercalStreams({"scale", "s.yaml", "--collapse", "--kappa", "40", "80",
                                           "--replicates", "2", "--out", "x", "--json"},
                                          folder.path());
  EXPECT_EQ(result.exit_status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("8/8 consolidation at E = "));
  const json document = json::parse(result.output);
  ASSERT_EQ(document["points"].size(), 4u);
  for (const json& point : document["points"]) {
    EXPECT_EQ(point["failures"].size() + point["responses"]["void_ratio"].size(), 2u);
  }
  EXPECT_NEAR(document["points"][0]["groups"]["kappa"].get<double>(), 40, 1e-6);
  EXPECT_FALSE(document["trends"].empty());
  EXPECT_FALSE(document["plateaus"].empty());
  EXPECT_EQ(ReadJson(folder / "x/collapse.json"), document);
  EXPECT_THAT(ReadFile(folder / "x/collapse.html"), HasSubstr("vegaEmbed('#f0'"));
}

TEST(ScaleCollapse, RefusesWhatItCannotDo) {
  const TemporaryFolder folder;
  Streams result = PowdercalStreams({"scale", "hastelloy_x_table3", "--collapse"}, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("simulates nothing"));
  result = PowdercalStreams({"scale", "quickstart", "--collapse", "--experiment", "sheer"},
                            folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("unknown experiment 'sheer'"));
  result = PowdercalStreams({"scale", "quickstart", "--kappa", "100"}, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("--collapse"));
}

}  // namespace
}  // namespace powdercal
