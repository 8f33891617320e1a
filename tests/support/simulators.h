#pragma once

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace powdercal {

/// Process numbers of the LIGGGHTS processes, or those of another program, that work in this folder
/// or below it.
inline std::vector<pid_t> SimulatorsIn(const std::filesystem::path& folder,
                                       const std::string& program = "liggghts") {
  std::vector<pid_t> found;
  std::error_code ignored;
  const std::string prefix = std::filesystem::weakly_canonical(folder).string();
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ignored)) {
    const std::string pid = entry.path().filename().string();
    if (pid.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string cwd = std::filesystem::read_symlink(entry.path() / "cwd", ignored).string();
    std::string command;
    std::getline(std::ifstream(entry.path() / "comm"), command);
    if (cwd.starts_with(prefix) && command.starts_with(program)) {
      found.push_back(static_cast<pid_t>(std::stol(pid)));
    }
  }
  return found;
}

}  // namespace powdercal
