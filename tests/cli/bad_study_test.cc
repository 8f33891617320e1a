#include <gmock/gmock.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Runs the study text as s.yaml and expects these pieces in the message, and nothing else done.
void ExpectRefused(const TemporaryFolder& folder, const std::string& study,
                   const std::vector<std::string>& message) {
  WriteFileAtomically(folder / "s.yaml", study);
  const std::vector<std::string> before = Listing(folder.path());
  const Streams result = PowdercalStreams({"run", "s.yaml", "--out", "x"}, folder.path());
  EXPECT_EQ(result.exit_status, 2);
  for (const std::string& piece : message) EXPECT_THAT(result.error, HasSubstr(piece));
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  EXPECT_EQ(result.output, "");
  EXPECT_EQ(Listing(folder.path()), before);
}

struct BadStudy {
  std::string from;
  std::string to;
  std::vector<std::string> message;
};

class BadStudies : public ::testing::TestWithParam<BadStudy> {};

TEST_P(BadStudies, AreRefusedWithPlaceKeyAndValue) {
  const TemporaryFolder folder;
  ExpectRefused(folder, StudyText("quickstart", GetParam().from, GetParam().to),
                GetParam().message);
}

// Lines and columns are those of the shipped quickstart.yaml.
INSTANTIATE_TEST_SUITE_P(
    Cli, BadStudies,
    ::testing::Values(
        BadStudy{"objective: joint",
                 "objectiv: joint",
                 {"s.yaml:29:1: unknown key 'objectiv'", "did you mean 'objective'?"}},
        BadStudy{"restitution: 0.4",
                 "restitition: 0.4",
                 {"s.yaml:11:3: material: ", "'restitution'", "'restitition'"}},
        BadStudy{"stress: 9 kPa",
                 "stress: 9",
                 {"s.yaml:22:15: experiments[0].consolidation.stress: '9' has no unit",
                  "expected a pressure"}},
        BadStudy{"unit: J/m3, ", "", {"s.yaml:17:", "missing unit", "such as J/m3"}},
        BadStudy{"stress: 9 kPa",
                 "stress: 9 mm",
                 {"s.yaml:22:15: experiments[0].consolidation.stress", "expected a pressure",
                  "got a length ('9 mm')"}},
        BadStudy{"stress: 9 kPa", "stress: 9 kPb", {"s.yaml:22:15: ", "'kPb' is not a unit"}},
        BadStudy{"range: [1e2, 1e5]",
                 "range: [1e5, 1e2]",
                 {"s.yaml:17:47: parameters.cohesion_energy_density.range: the lower bound 100000 "
                  "is not below the upper bound 100"}},
        BadStudy{"range: [0.05, 0.7]", "range: [0.5, 0.5]", {"s.yaml:18:43: ", "is not below"}},
        BadStudy{"range: [0.05, 0.7]", "range: [-0.05, 0.7]", {"s.yaml:18:43: ", "negative"}},
        BadStudy{"range: [0.05, 0.7]", "range: [0.05, .inf]", {"s.yaml:18:50: ", "'.inf'"}},
        BadStudy{"range: [1e2, 1e5]", "range: [0, 1e5]", {"s.yaml:17:47: ", "log scale"}},
        BadStudy{"rolling_friction: {",
                 "rollin_friction: {",
                 {"s.yaml:18:3: parameters: unknown parameter 'rollin_friction'",
                  "did you mean 'rolling_friction'?"}},
        BadStudy{"name: embedded",
                 "name: embeded",
                 {"s.yaml:31:17: backend.name: unknown backend 'embeded' (valid: ",
                  "did you mean 'embedded'?"}},
        BadStudy{"name: embedded,",
                 "name: embedded, threads: 0,",
                 {"s.yaml:31:36: backend.threads: must lie in [1, ", "(found '0')"}},
        BadStudy{"name: embedded,",
                 "name: embedded, threads: 1.5,",
                 {"s.yaml:31:36: backend.threads: expected an integer (found '1.5')"}},
        BadStudy{"name: embedded,",
                 "name: embedded, isa: sse9,",
                 {"s.yaml:31:32: backend.isa: unknown instruction set 'sse9' (valid: auto, "}},
        BadStudy{"name: embedded,",
                 "name: liggghts, threads: 2,",
                 {"s.yaml:31:27: backend: unknown key 'threads' (valid: "}},
        BadStudy{"name: bayesian",
                 "name: baysian",
                 {"s.yaml:30:19: optimizer.name: unknown optimizer 'baysian'",
                  "did you mean 'bayesian'?"}},
        BadStudy{"acquisition: composite_log_ei",
                 "acquisition: composit_log_ei",
                 {"s.yaml:30:42: optimizer.acquisition: unknown acquisition 'composit_log_ei'",
                  "did you mean 'composite_log_ei'?"}},
        BadStudy{"initial_design: corners_and_centre",
                 "initial_design: corners_and_center",
                 {"s.yaml:30:76: optimizer.initial_design.name: unknown design",
                  "did you mean 'corners_and_centre'?"}},
        BadStudy{"- consolidation:",
                 "- consolidaton:",
                 {"s.yaml:21:5: experiments: unknown experiment 'consolidaton'",
                  "did you mean 'consolidation'?"}},
        BadStudy{"void_ratio:",
                 "voidratio:",
                 {"s.yaml:24:9: unknown consolidation response 'voidratio'",
                  "did you mean 'void_ratio'?"}},
        BadStudy{"mode: given", "mode: gven", {"s.yaml:19:17: ", "did you mean 'given'?"}},
        BadStudy{"density: 8220 kg/m3",
                 "density: -8220 kg/m3",
                 {"s.yaml:8:12: material.density: must be above 0 kg/m3 (found '-8220 kg/m3')"}},
        BadStudy{"density: 8220 kg/m3", "density: nan kg/m3", {"s.yaml:8:12: ", "'nan kg/m3'"}},
        BadStudy{"density: 8220 kg/m3", "density: 1e400 kg/m3", {"s.yaml:8:12: ", "1e400"}},
        BadStudy{"restitution: 0.4",
                 "restitution: 1.4",
                 {"s.yaml:11:16: material.restitution: must lie in (0, 1] (found '1.4')"}},
        BadStudy{"min: 12.5 um",
                 "min: 52.5 um",
                 {"s.yaml:14:75: material.sizes.max: the largest diameter must be above"}},
        BadStudy{"mean: 29 um",
                 "mean: 39 um",
                 {"s.yaml:14:39: material.sizes.mean: ", "between min and max"}},
        BadStudy{"sd: 0.01",
                 "sd: 0",
                 {"s.yaml:26:15: experiments[0].consolidation.observed.void_ratio.sd: must be "
                  "above 0 (found '0')"}},
        BadStudy{"tolerance: 0.01", "tolerance: -0.01", {"s.yaml:27:22: ", "(found '-0.01')"}},
        BadStudy{"replicates: 3,", "replicates: 0,", {"s.yaml:31:56: backend.replicates: "}},
        BadStudy{"confirm_replicates: 6",
                 "confirm_replicates: 2",
                 {"s.yaml:31:79: backend.confirm_replicates: must lie in [3, ", "(found '2')"}},
        BadStudy{"evaluations: 20", "evaluations: 0", {"s.yaml:32:23: budget.evaluations: "}},
        BadStudy{"objective: joint",
                 "objective: joint\nobjective: joint",
                 {"s.yaml:30:1: key 'objective' appears twice"}},
        BadStudy{"  poisson_ratio: 0.3", "\tpoisson_ratio: 0.3", {"s.yaml:10:2: ", "no tabs"}},
        BadStudy{"{particle: 0.3, wall: 0.3}", "{particle: 0.3, wall: 0.3", {"s.yaml:13:17: "}},
        BadStudy{"young_modulus: 5 MPa",
                 "young_modulus: 5 TPa",
                 {"scaling 'given' of consolidation", "above the powder's (200 GPa)"}}));

// In the place of the quickstart's scaling.
struct BadScaling {
  std::string scaling;
  std::vector<std::string> message;
};

class BadScalings : public ::testing::TestWithParam<BadScaling> {};

TEST_P(BadScalings, AreRefusedWithWhatIsMissing) {
  const TemporaryFolder folder;
  ExpectRefused(folder,
                StudyText("quickstart", "{mode: given, young_modulus: 5 MPa, stress: 0.9 kPa}",
                          GetParam().scaling),
                GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Cli, BadScalings,
    ::testing::Values(
        BadScaling{"{mode: exact, young_modulus: 5 TPa}",
                   {"scaling 'exact' of consolidation", "above the powder's (200 GPa)"}},
        BadScaling{"exact", {"s.yaml:19:10: scaling: missing key 'young_modulus'"}},
        BadScaling{"{mode: exact, young_modulus: -5 MPa}",
                   {"s.yaml:19:39: scaling.young_modulus: must be above 0 Pa (found '-5 MPa')"}},
        BadScaling{"{mode: exact, young_modulus: 0 Pa}", {"must be above 0 Pa (found '0 Pa')"}},
        BadScaling{"{mode: exact, young_modulus: 5 mm}", {"expected a pressure", "got a length"}},
        BadScaling{"{mode: rigid_limit, kapa: 1000}",
                   {"s.yaml:19:30: scaling: unknown key 'kapa'", "did you mean 'kappa'?"}},
        BadScaling{"{mode: rigid_limit, kappa: 0}",
                   {"s.yaml:19:37: scaling.kappa: must lie in [1, 100000000] (found '0')"}},
        BadScaling{"{mode: rigid, kappa: 1000}",
                   {"s.yaml:19:17: ", "unknown scaling mode 'rigid'"}},
        BadScaling{"{mode: custom, young_modulus: 5 MPa, groups: {sigma/e: 1}}",
                   {"s.yaml:19:56: unknown group 'sigma/e'", "did you mean 'sigma/E'?"}},
        BadScaling{"{mode: custom, young_modulus: 5 MPa, groups: {sigma/E: 1, V/sqrt(g d): 1}}",
                   {"scaling 'custom': no experiment of the study has the group 'V/sqrt(g d)'"}},
        BadScaling{"{mode: custom, young_modulus: 5 MPa, keep: [gravity], groups: {sigma/E: 1, "
                   "sigma/(rho_b g h): 1}}",
                   {"scaling 'custom' of consolidation: these groups cannot be matched together",
                    "sigma/E (off", "sigma/(rho_b g h) (off"}},
        BadScaling{"{mode: custom, young_modulus: 5 MPa, keep: [mass], groups: {sigma/E: 1}}",
                   {"s.yaml:19:54: scaling.keep: unknown quantity 'mass'", "valid: cohesion, "}}));

TEST(BadScaling, NeedsWhatTheStudyLacks) {
  const TemporaryFolder folder;
  std::string text = StudyText("quickstart", "{mode: given, young_modulus: 5 MPa, stress: 0.9 kPa}",
                               "{mode: custom, young_modulus: 5 MPa, groups: {Bo: 1}}");
  const std::size_t energy = text.find("  surface_energy");
  text.erase(energy, text.find('\n', energy) + 1 - energy);
  ExpectRefused(folder, text,
                {"no experiment of the study has the group 'Bo'", "material.surface_energy"});

  text = StudyText("quickstart", "{mode: given, young_modulus: 5 MPa, stress: 0.9 kPa}",
                   "rigid_limit");
  const std::size_t experiments = text.find("  - consolidation:");
  text.replace(experiments, text.find("objective:") - experiments,
               "  - spreading: {observed: {coverage: {value: 0.9, sd: 0.05}}}\n");
  ExpectRefused(folder, text,
                {"scaling 'rigid_limit' of spreading: ", "kappa",
                 "no experiment of the study applies a stress"});
}

TEST(BadFiles, AreNotTakenForStudies) {
  for (const std::string& text : {std::string(), std::string("# a comment\n"),
                                  std::string("quickstart\n"), std::string("- a\n- b\n"),
                                  std::string("\x7f"
                                              "ELF\x02\x01\x00\xff\xfe\n",
                                              10)}) {
    const TemporaryFolder folder;
    ExpectRefused(folder, text, {"powdercal: s.yaml:1:"});
  }
}

// A table study whose table is t.csv.
void ExpectTableRefused(const std::string& csv, const std::vector<std::string>& message) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "t.csv", csv);
  ExpectRefused(folder, StudyText("hastelloy_x_table3", "hastelloy_x_table3.csv", "t.csv"),
                message);
}

const std::string kRows = "100,0.05,0.57\n1e5,0.7,1.4\n100,0.7,0.56\n1e5,0.05,1.1\n";

TEST(BadTables, AreRefused) {
  const std::string header =
      "cohesion_energy_density [J/m3],rolling_friction,consolidation.void_ratio\n";
  ExpectTableRefused(header + kRows + "500,zero,0.6\n",
                     {"t.csv:6:5: rolling_friction: expected a number (found 'zero')"});
  ExpectTableRefused(header + kRows + "500,0.6\n", {"t.csv:6:8: expected 3 fields, found 2"});
  ExpectTableRefused(header + kRows + "500,,0.6\n",
                     {"t.csv:6:5: rolling_friction: a number is missing"});
  ExpectTableRefused(header + kRows + "500,0.4,inf\n", {"t.csv:6:9: ", "(found 'inf')"});
  ExpectTableRefused(header, {"t.csv:1:", "no rows"});
  ExpectTableRefused("", {"t.csv: the file is empty"});
  ExpectTableRefused(
      "cohesion_energy_density [J/m3],rolling_frction,consolidation.void_ratio\n" + kRows,
      {"t.csv: unknown column 'rolling_friction'", "did you mean 'rolling_frction'?"});
  ExpectTableRefused("cohesion_energy_density [J/m3],consolidation.void_ratio\n1,2\n2,3\n3,4\n",
                     {"t.csv: unknown column 'rolling_friction'",
                      "(valid: cohesion_energy_density, consolidation.void_ratio)"});
  ExpectTableRefused(
      "cohesion_energy_density [m],rolling_friction,consolidation.void_ratio\n" + kRows,
      {"t.csv: cohesion_energy_density: ", "pressure", "length"});
}

TEST(BadTables, MissingOnesAreNamed) {
  const TemporaryFolder folder;
  ExpectRefused(folder, StudyText("hastelloy_x_table3", "hastelloy_x_table3.csv", "absent.csv"),
                {"s.yaml:39:30: backend.file: ", "absent.csv", "No such file or directory"});
}

// A program that is called liggghts, made by this script.
std::string RunWithSimulator(const std::string& script) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "bin");
  if (!script.empty()) {
    WriteFileAtomically(folder / "bin/liggghts", script);
    std::filesystem::permissions(folder / "bin/liggghts", std::filesystem::perms::owner_all);
  }
  const ProcessResult result =
      Powdercal({"run", "quickstart", "--backend", "liggghts", "--out", "x"}, folder.path(),
                {{"PATH", (folder / "bin").string()}});
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(Listing(folder.path()), ElementsAre("bin"));
  EXPECT_THAT(result.output, HasSubstr("backend 'liggghts' is not available: "));
  return result.output;
}

TEST(BadSimulators, AreToldFromLiggghts) {
  EXPECT_THAT(RunWithSimulator(""), HasSubstr("no program 'liggghts' on PATH"));
  EXPECT_THAT(RunWithSimulator("#!/bin/sh\necho hello\n"),
              HasSubstr("bin/liggghts does not answer as LIGGGHTS"));
  EXPECT_THAT(RunWithSimulator("no program"), HasSubstr("Exec format error"));
}

TEST(BadSimulators, CheckReportsThemBesideThePlan) {
  const TemporaryFolder folder;
  const ProcessResult result = Powdercal({"check", "quickstart", "--backend", "liggghts"},
                                         folder.path(), {{"PATH", (folder / "nowhere").string()}});
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.output, HasSubstr("no program 'liggghts' on PATH"));
  EXPECT_THAT(result.output, HasSubstr("# plan"));
  EXPECT_THAT(Listing(folder.path()), IsEmpty());
}

}  // namespace
}  // namespace powdercal
