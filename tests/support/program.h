#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/files.h"
#include "core/process.h"

namespace powdercal {

/// A folder of its own for a test, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "powdercal-test-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Runs the built program with these arguments.
inline ProcessResult Powdercal(std::vector<std::string> arguments,
                               const std::filesystem::path& working_directory = {},
                               std::vector<std::pair<std::string, std::string>> environment = {}) {
  arguments.insert(arguments.begin(), POWDERCAL_PROGRAM);
  return RunProcess({.arguments = std::move(arguments),
                     .working_directory = working_directory,
                     .environment = std::move(environment),
                     .time_limit = std::chrono::minutes(15),
                     .output_limit = 1 << 20});
}

inline nlohmann::json ReadJson(const std::filesystem::path& file) {
  return nlohmann::json::parse(ReadFile(file));
}

inline std::filesystem::path LibraryStudy(const std::string& name) {
  return std::filesystem::path(POWDERCAL_SOURCE_DIR) / "studies" / "library" / (name + ".yaml");
}

/// A copy of a shipped study with one piece of its text replaced, which must occur in it.
inline std::string StudyText(const std::string& name, const std::string& from = "",
                             const std::string& to = "") {
  std::string text = ReadFile(LibraryStudy(name));
  if (from.empty()) return text;
  const std::size_t position = text.find(from);
  EXPECT_NE(position, std::string::npos) << "no '" << from << "' in " << name;
  if (position != std::string::npos) text.replace(position, from.size(), to);
  return text;
}

}  // namespace powdercal
