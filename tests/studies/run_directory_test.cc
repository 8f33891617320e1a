#include "studies/run_directory.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "studies/ledger.h"
#include "tests/support/program.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string MessageFor(const fs::path& folder, const std::string& fingerprint = "a") {
  try {
    RunDirectory directory(folder, fingerprint, "study: x\n");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(RunDirectory, CreatesAndReopens) {
  const TemporaryFolder folder;
  EXPECT_EQ(MessageFor(folder / "runs/x"), "no error");
  EXPECT_TRUE(fs::exists(folder / "runs/x/ledger.sqlite"));
  EXPECT_EQ(ReadFile(folder / "runs/x/study.yaml"), "study: x\n");
  EXPECT_EQ(MessageFor(folder / "runs/x"), "no error");
}

TEST(RunDirectory, RefusesAnotherStudy) {
  const TemporaryFolder folder;
  ASSERT_EQ(MessageFor(folder / "x", "a"), "no error");
  EXPECT_THAT(MessageFor(folder / "x", "b"), HasSubstr("belongs to another study"));
  EXPECT_THAT(RunDirectory::Explain(folder / "x", "b"), HasSubstr("belongs to another study"));
  EXPECT_EQ(RunDirectory::Explain(folder / "x", "a"), "");
}

TEST(RunDirectory, RefusesAFolderWithOtherThings) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "x");
  WriteFileAtomically(folder / "x/thesis.tex", "precious");
  EXPECT_THAT(MessageFor(folder / "x"), HasSubstr("thesis.tex"));
  EXPECT_FALSE(fs::exists(folder / "x/ledger.sqlite"));
  EXPECT_FALSE(fs::exists(folder / "x/lock"));
}

TEST(RunDirectory, OneOwnerAtATime) {
  const TemporaryFolder folder;
  const RunDirectory first(folder / "x", "a", "");
  EXPECT_THAT(MessageFor(folder / "x"), HasSubstr("held by another powdercal process"));
}

TEST(RunDirectory, LockEndsWithAKilledOwner) {
  const TemporaryFolder folder;
  const fs::path path = folder / "x";
  const pid_t child = fork();
  if (child == 0) {
    try {
      const RunDirectory owner(path, "a", "");
      kill(getpid(), SIGKILL);
    } catch (...) {
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(MessageFor(path), "no error");
}

// Root may write anywhere, so this needs a place where nobody can.
TEST(RunDirectory, UnwritableFolderLeavesNothing) {
  EXPECT_THAT(MessageFor("/proc/powdercal/x"), HasSubstr("cannot write the run folder"));
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "file", "");
  EXPECT_NE(MessageFor(folder / "file/x"), "no error");
  EXPECT_THAT(MessageFor(folder / "file"), HasSubstr("is a file"));
}

}  // namespace
}  // namespace powdercal
