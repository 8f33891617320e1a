#pragma once

#include <filesystem>
#include <string>

namespace powdercal {

/// The folder of one study: study.yaml, ledger.sqlite, results.json, report.html,
/// material_card.yaml, runs/<id>/. While a process owns it, no other one can: it holds a lock on
/// `lock`, which the system releases when the process ends, however it ends.
class RunDirectory {
 public:
  /// Opens or creates the folder for a study with this fingerprint, and locks it; `base_folder` is
  /// where relative paths in the study start, for resuming from the folder alone. Throws
  /// InputError, leaving nothing behind, when the folder cannot be written, holds something else,
  /// belongs to another study, or is owned by another process.
  RunDirectory(const std::filesystem::path& folder, const std::string& fingerprint,
               const std::string& study_yaml, const std::filesystem::path& base_folder = {});
  ~RunDirectory();

  /// Why a study with this fingerprint could not use the folder, or ""; creates and locks nothing.
  static std::string Explain(const std::filesystem::path& folder, const std::string& fingerprint);

  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path ledger() const { return folder_ / "ledger.sqlite"; }
  std::filesystem::path work_folder(const std::string& name) const {
    return folder_ / "runs" / name;
  }

 private:
  void Lock();

  std::filesystem::path folder_;
  int lock_ = -1;
};

}  // namespace powdercal
