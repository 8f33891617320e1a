#include "core/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/errors.h"

namespace powdercal {
namespace {

class FilesTest : public testing::Test {
 protected:
  FilesTest() { std::filesystem::create_directories(folder_); }
  ~FilesTest() override { std::filesystem::remove_all(folder_); }

  std::size_t FileCount() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  const std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                        ("powdercal_files_test." + std::to_string(getpid()));
};

TEST_F(FilesTest, ReadsBackWhatWasWritten) {
  const std::string text("first\r\n\0second", 14);
  WriteFileAtomically(folder_ / "file", text);
  EXPECT_EQ(ReadFile(folder_ / "file"), text);
}

TEST_F(FilesTest, ReplacesAndLeavesNothingElseBehind) {
  WriteFileAtomically(folder_ / "file", "a long first text");
  WriteFileAtomically(folder_ / "file", "second");
  EXPECT_EQ(ReadFile(folder_ / "file"), "second");
  EXPECT_EQ(FileCount(), 1U);
}

TEST_F(FilesTest, AnEmptyFileIsReadable) {
  WriteFileAtomically(folder_ / "file", "");
  EXPECT_EQ(ReadFile(folder_ / "file"), "");
}

TEST_F(FilesTest, LargerThanTheBuffer) {
  const std::string text(100000, 'x');
  WriteFileAtomically(folder_ / "file", text);
  EXPECT_EQ(ReadFile(folder_ / "file"), text);
}

TEST_F(FilesTest, ReadingErrorsNameTheFileAndTheReason) {
  try {
    ReadFile(folder_ / "absent");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().location.file, (folder_ / "absent").string());
    EXPECT_EQ(error.problem(), "cannot read the file: No such file or directory");
  }
  EXPECT_THROW(ReadFile(folder_), InputError);
}

TEST_F(FilesTest, WritingErrorsNameTheFileAndTheReason) {
  std::filesystem::create_directory(folder_ / "taken");
  EXPECT_THROW(WriteFileAtomically(folder_ / "taken", "text"), InputError);
  EXPECT_EQ(FileCount(), 1U);  // no temporary file is left
  try {
    WriteFileAtomically(folder_ / "absent" / "file", "text");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problem(), "cannot write the file: No such file or directory");
  }
}

TEST_F(FilesTest, ConcurrentWritersNeverMixTheirTexts) {
  std::vector<std::jthread> writers;
  for (const char letter : {'a', 'b', 'c'}) {
    writers.emplace_back([&, letter] {
      for (int i = 0; i < 20; ++i) {
        WriteFileAtomically(folder_ / "file", std::string(20000, letter));
      }
    });
  }
  writers.clear();
  const std::string text = ReadFile(folder_ / "file");
  EXPECT_EQ(text, std::string(20000, text.at(0)));
  EXPECT_EQ(FileCount(), 1U);
}

}  // namespace
}  // namespace powdercal
