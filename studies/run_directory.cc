#include "studies/run_directory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "core/errors.h"
#include "core/files.h"
#include "studies/ledger.h"

namespace powdercal {
namespace fs = std::filesystem;
namespace {

constexpr const char* kLedgerFile = "ledger.sqlite";
constexpr const char* kLockFile = "lock";

// The topmost folder that has to be created, so that a failure can take back exactly what was made.
fs::path FirstMissing(const fs::path& folder) {
  fs::path missing;
  for (fs::path path = folder; !path.empty() && !fs::exists(path); path = path.parent_path()) {
    missing = path;
  }
  return missing;
}

fs::path Normalised(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return path.filename().empty() ? path.parent_path() : path;
}

std::string OwnerMismatch(const Ledger& ledger, const std::string& fingerprint) {
  const auto owner = ledger.GetMeta("fingerprint");
  if (!owner || *owner == fingerprint) return "";
  return "the run folder belongs to another study, or to another version of this one; choose "
         "another "
         "with --out, or remove it";
}

// Says who holds the lock file, or ""; does not make one.
std::string HolderOf(const fs::path& file) {
  const int lock = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) return "";
  const bool held = flock(lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(lock);
  if (!held) return "";
  std::string owner;
  std::getline(std::ifstream(file), owner);
  return fmt::format("the ledger is held by another powdercal process{}{}",
                     owner.empty() ? "" : ", number ", owner);
}

}  // namespace

std::string RunDirectory::Explain(const fs::path& folder, const std::string& fingerprint) {
  const fs::path path = Normalised(folder);
  if (fs::exists(path) && !fs::is_directory(path)) return "the run folder is a file";
  const fs::path missing = FirstMissing(path);
  const fs::path existing = missing.empty() ? path : missing.parent_path();
  if (!fs::is_directory(existing)) {
    return fmt::format("cannot write the run folder: '{}' is a file", existing.string());
  }
  // access() alone does not tell for /proc and its like, where root may write and nobody can.
  std::string probe = (existing / ".powdercal-XXXXXX").string();
  if (mkdtemp(probe.data()) == nullptr) {
    return fmt::format("cannot write the run folder: {}", std::strerror(errno));
  }
  rmdir(probe.c_str());
  if (!missing.empty()) return "";
  if (const std::string owner = HolderOf(path / kLockFile); !owner.empty()) return owner;
  if (fs::exists(path / kLedgerFile) && !Ledger::IsBlank(path / kLedgerFile)) {
    return OwnerMismatch(Ledger(path / kLedgerFile, Ledger::Mode::read_only), fingerprint);
  }
  for (const auto& entry : fs::directory_iterator(path)) {
    const std::string name = entry.path().filename().string();
    if (name == kLockFile || name.starts_with(kLedgerFile)) continue;  // of a killed process
    return fmt::format(
        "the folder holds other things ('{}') and no study; choose another with --out", name);
  }
  return "";
}

RunDirectory::RunDirectory(const fs::path& folder, const std::string& fingerprint,
                           const std::string& study_yaml, const fs::path& base_folder)
    : folder_(Normalised(folder)) {
  if (const std::string reason = Explain(folder_, fingerprint); !reason.empty()) {
    throw InputError(reason, {.location = {folder_.string()}});
  }
  const fs::path created = FirstMissing(folder_);
  const bool fresh = !fs::exists(ledger());
  std::error_code error;
  fs::create_directories(folder_, error);
  bool locked = false;
  try {
    if (error) {
      throw InputError(fmt::format("cannot write the run folder: {}", error.message()),
                       {.location = {folder_.string()}});
    }
    Lock();
    locked = true;
    Ledger record(ledger(), Ledger::Mode::read_write);
    if (const std::string reason = OwnerMismatch(record, fingerprint); !reason.empty()) {
      throw InputError(reason, {.location = {folder_.string()}});
    }
    record.SetMeta("fingerprint", fingerprint);
    record.SetMeta("base_folder", base_folder.string());
    WriteFileAtomically(folder_ / "study.yaml", study_yaml);
  } catch (...) {
    // Take back what was made here; a folder that another process holds is not ours to touch.
    if (!created.empty()) {
      fs::remove_all(created, error);
    } else if (fresh && locked) {
      for (const char* suffix : {"", "-wal", "-shm"}) {
        fs::remove(ledger().string() + suffix, error);
      }
      fs::remove(folder_ / kLockFile, error);
    }
    if (lock_ >= 0) close(lock_);
    throw;
  }
}

RunDirectory::~RunDirectory() {
  if (lock_ >= 0) close(lock_);
}

void RunDirectory::Lock() {
  const fs::path file = folder_ / kLockFile;
  lock_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0) {
    throw InputError(fmt::format("cannot write the run folder: {}", std::strerror(errno)),
                     {.location = {folder_.string()}});
  }
  // Somebody who only looks (HolderOf) holds it for a moment.
  bool locked = flock(lock_, LOCK_EX | LOCK_NB) == 0;
  for (int attempt = 0; !locked && attempt < 5; ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    locked = flock(lock_, LOCK_EX | LOCK_NB) == 0;
  }
  if (!locked) {
    const std::string holder = HolderOf(file);
    throw InputError(holder.empty() ? "the ledger is held by another powdercal process" : holder,
                     {.location = {folder_.string()}});
  }
  const std::string text = std::to_string(getpid()) + "\n";
  if (ftruncate(lock_, 0) != 0 || write(lock_, text.data(), text.size()) < 0) {
    throw InputError(fmt::format("cannot write the run folder: {}", std::strerror(errno)),
                     {.location = {folder_.string()}});
  }
}

}  // namespace powdercal
