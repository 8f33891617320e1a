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

}  // namespace
}  // namespace powdercal
