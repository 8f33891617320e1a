#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>

#include "tests/cli/streams.h"

namespace powdercal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Streams RunTable(const TemporaryFolder& folder, const std::string& out,
                 std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"run", "hastelloy_x_table3", "--evaluations", "6", "--out",
                                        out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return PowdercalStreams(arguments, folder.path());
}

// Root may write anywhere, so these are places where nobody can.
TEST(RunFolder, UnwritableOnesAreRefusedBeforeAnythingIsMade) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "file", "precious");
  for (const char* out : {"/proc/powdercal", "/proc/powdercal/x", "file", "file/x"}) {
    const Streams result = RunTable(folder, out);
    EXPECT_EQ(result.exit_status, 2) << out;
    EXPECT_THAT(result.error, HasSubstr(std::string(out) + ": ")) << out;
    EXPECT_THAT(result.error, HasSubstr("the run folder")) << out;
    EXPECT_EQ(result.output, "");
    const Streams check =
        PowdercalStreams({"check", "hastelloy_x_table3", "--out", out}, folder.path());
    EXPECT_EQ(check.exit_status, 2) << out;
    EXPECT_THAT(check.error, HasSubstr("the run folder")) << out;
  }
  EXPECT_THAT(Listing(folder.path()), ElementsAre("file"));
  EXPECT_EQ(ReadFile(folder / "file"), "precious");
}

TEST(RunFolder, OthersContentIsLeftAlone) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "x");
  WriteFileAtomically(folder / "x/thesis.tex", "precious");
  const Streams result = RunTable(folder, "x");
  EXPECT_EQ(result.exit_status, 2);
  EXPECT_THAT(result.error, HasSubstr("holds other things ('thesis.tex')"));
  EXPECT_THAT(Listing(folder / "x"), ElementsAre("thesis.tex"));
}

TEST(RunFolder, AnotherStudysIsRefused) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunTable(folder, "x").exit_status, 0);
  const std::string before = ReadFile(folder / "x/results.json");
  for (const std::vector<std::string>& other :
       {std::vector<std::string>{"--seed", "2"},
        {"--set", "experiments[0].consolidation.stress=8 kPa"}}) {
    const Streams result = RunTable(folder, "x", other);
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_THAT(result.error, HasSubstr("belongs to another study"));
    EXPECT_THAT(result.error, HasSubstr("--out"));
  }
  EXPECT_EQ(ReadFile(folder / "x/results.json"), before);
}

TEST(RunFolder, HeldByAnotherProcessIsRefusedButCanBeReported) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunTable(folder, "x").exit_status, 0);
  const int lock = open((folder / "x/lock").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(lock, 0);
  ASSERT_EQ(flock(lock, LOCK_EX | LOCK_NB), 0);
  const std::string owner = ReadFile(folder / "x/lock");
  for (const Streams& result :
       {RunTable(folder, "x"), PowdercalStreams({"resume", "x"}, folder.path()),
        PowdercalStreams({"check", "hastelloy_x_table3", "--out", "x"}, folder.path())}) {
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_THAT(result.error, HasSubstr("held by another powdercal process, number "));
  }
  EXPECT_EQ(ReadFile(folder / "x/lock"), owner);
  EXPECT_EQ(PowdercalStreams({"report", "x"}, folder.path()).exit_status, 0);
  close(lock);
  EXPECT_EQ(RunTable(folder, "x").exit_status, 0);
}

TEST(RunFolder, LedgersThatAreNoneAreNamed) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunTable(folder, "x").exit_status, 0);
  WriteFileAtomically(folder / "x/ledger.sqlite", std::string(5000, '?'));
  for (const Streams& result :
       {RunTable(folder, "x"), PowdercalStreams({"resume", "x"}, folder.path()),
        PowdercalStreams({"report", "x"}, folder.path())}) {
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_THAT(result.error, HasSubstr("x/ledger.sqlite: cannot open the ledger"));
  }
}

TEST(RunFolder, DamagedLedgersAreNamed) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunTable(folder, "x").exit_status, 0);
  std::string ledger = ReadFile(folder / "x/ledger.sqlite");
  ASSERT_GT(ledger.size(), 16384u);
  ledger.replace(4200, 9000, std::string(9000, '?'));
  WriteFileAtomically(folder / "x/ledger.sqlite", ledger);
  for (const Streams& result :
       {RunTable(folder, "x"), PowdercalStreams({"resume", "x"}, folder.path()),
        PowdercalStreams({"report", "x"}, folder.path())}) {
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_THAT(result.error, HasSubstr("x/ledger.sqlite: "));
  }
}

TEST(RunFolder, DefaultIsNamedAfterTheStudyAndItsSeed) {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& seed :
       {std::vector<std::string>{}, {"--seed", "4"}, {"--set", "seed=5"}}) {
    std::vector<std::string> arguments = {"run", "hastelloy_x_table3", "--evaluations", "5"};
    arguments.insert(arguments.end(), seed.begin(), seed.end());
    EXPECT_EQ(PowdercalStreams(arguments, folder.path()).exit_status, 0);
  }
  EXPECT_THAT(Listing(folder.path()), ElementsAre("runs"));
  EXPECT_THAT(
      Listing(folder / "runs"),
      ElementsAre("hastelloy-x-table3", "hastelloy-x-table3-seed4", "hastelloy-x-table3-seed5"));
}

}  // namespace
}  // namespace powdercal
