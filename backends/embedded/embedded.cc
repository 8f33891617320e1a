#include "backends/embedded/embedded.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "backends/embedded/kernels.h"
#include "backends/embedded/limits.h"
#include "backends/embedded/stages.h"
#include "core/errors.h"
#include "core/files.h"

namespace powdercal {
namespace {

using embedded::Isa;

// To be raised whenever the same program gives other numbers.
constexpr const char* kVersion = "1";

class EmbeddedBackend final : public Backend {
 public:
  const std::string& name() const override {
    static const std::string kName = "embedded";
    return kName;
  }

  Availability availability() const override { return {.available = true, .version = kVersion}; }

  bool writes_snapshots() const override { return true; }

  void Serialize(Archive& archive) override {
    archive.Integer("threads", threads_, {.lower = 1, .upper = 256});
    archive.Choice("isa", isa_, "instruction set", IsaChoices());
  }

  std::vector<std::string> Prepare(const BackendProblem&) override {
    if (isa_ != "auto" && !embedded::Has(WantedIsa())) {
      throw InputError("this processor does not have the instruction set",
                       {.key = "backend.isa", .value = isa_});
    }
    std::vector<std::string> warnings;
    if (threads_ > MachineCores()) {
      warnings.push_back(fmt::format("backend.threads: {} threads on {} cores are slower than {}",
                                     threads_, MachineCores(), MachineCores()));
    }
    return warnings;
  }

  std::string Describe() const override {
    return fmt::format("built in, {}, {} thread{}", embedded::IsaNames()[IsaIndex()], threads_,
                       threads_ == 1 ? "" : "s");
  }

  int cores() const override { return threads_; }

  // Of the quickstart study's bed: docs/backends.md.
  double Throughput(const Program&) const override {
    static constexpr std::array kOneThread = {1.4e7, 3.2e7, 4e7};
    return kOneThread.at(IsaIndex()) * std::min(threads_, MachineCores());
  }

  std::string ExplainUnsupported(const Program& program) const override {
    return embedded::ExplainUnsupported(program);
  }

  Trace Run(const Program& program, const RunContext& context) const override {
    if (const std::string reason = ExplainUnsupported(program); !reason.empty()) {
      return {.outcome = {Reason::unsupported, reason}};
    }
    Trace trace;
    try {
      trace =
          embedded::StageRunner(program, context, {.isa = WantedIsa(), .threads = threads_}).Run();
    } catch (const InputError& error) {
      trace.outcome = {Reason::invalid_input, error.what()};
    }
    if (!trace.outcome.ok() && trace.outcome.reason != Reason::cancelled) {
      KeepFailure(program, trace.outcome, context.work_folder);
    }
    return trace;
  }

 private:
  // What it takes to look into a failure: beside these, the last state as a snapshot.
  static void KeepFailure(const Program& program, const Outcome& outcome,
                          const std::filesystem::path& folder) {
    if (folder.empty()) return;
    std::filesystem::create_directories(folder);
    WriteFileAtomically(folder / "program.json", program.ToJson().dump(1));
    WriteFileAtomically(folder / "outcome.txt",
                        fmt::format("{}: {}\n", ToString(outcome.reason), outcome.message));
  }

  static std::span<const std::string> IsaChoices() {
    static const std::vector<std::string> choices = [] {
      std::vector<std::string> list = {"auto"};
      for (const std::string& name : embedded::IsaNames()) list.push_back(name);
      return list;
    }();
    return choices;
  }

  Isa WantedIsa() const {
    const std::span<const std::string> names = embedded::IsaNames();
    for (std::size_t n = 0; n < names.size(); ++n) {
      if (names[n] == isa_) return static_cast<Isa>(n);
    }
    return embedded::BestIsa();
  }

  static int MachineCores() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }

  std::size_t IsaIndex() const { return static_cast<std::size_t>(WantedIsa()); }

  int threads_ = 1;
  std::string isa_ = "auto";
};

}  // namespace

std::unique_ptr<Backend> MakeEmbeddedBackend() { return std::make_unique<EmbeddedBackend>(); }

}  // namespace powdercal
