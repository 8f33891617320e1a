#include "backends/yade/yade.h"

#include <fmt/format.h>

#include <map>
#include <mutex>
#include <system_error>
#include <utility>

#include "backends/insertion.h"
#include "backends/work_folder.h"
#include "backends/yade/driver.h"
#include "backends/yade/job.h"
#include "backends/yade/result.h"
#include "backends/yade/unsupported.h"
#include "core/errors.h"
#include "core/process.h"

namespace powdercal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPackage = "Debian: apt-get install yade";
constexpr const char* kDriverFolder = "driver";

// Debian's place for the package, whatever the architecture is called.
fs::path FindModules() {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/usr/lib", error)) {
    const fs::path modules = entry.path() / "yade-double/py";
    if (fs::exists(modules / "yade/__init__.py", error)) return modules;
  }
  return {};
}

std::string LastLine(const std::string& output) {
  const std::size_t end = output.find_last_not_of(" \n");
  if (end == std::string::npos) return "no output";
  const std::size_t begin = output.rfind('\n', end);
  return output.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

Availability Probe(const YadeInstallation& installation) {
  static constexpr std::string_view kMark = "powdercal: YADE ";
  const std::string script = fmt::format(
      "import sys; sys.path.insert(0, sys.argv[1]); import numpy; import yade; "
      "print('{}' + yade.config.version)",
      kMark);
  const ProcessResult result = RunProcess({.arguments = {installation.python.string(), "-I", "-c",
                                                         script, installation.modules.string()},
                                           .environment = {{"OMP_NUM_THREADS", "1"}},
                                           .time_limit = std::chrono::seconds(60)});
  const std::size_t mark = result.output.find(kMark);
  if (!result.succeeded() || mark == std::string::npos) {
    return {.why_not = fmt::format("{} cannot import YADE from {}: it {}: {} ({})",
                                   installation.python.string(), installation.modules.string(),
                                   result.Describe(), LastLine(result.output), kPackage)};
  }
  const std::size_t start = mark + kMark.size();
  const std::string version = result.output.substr(start, result.output.find('\n', start) - start);
  return {.available = true, .version = version};
}

class YadeBackend final : public Backend {
 public:
  explicit YadeBackend(YadeInstallation installation) : installation_(std::move(installation)) {
    if (installation_.modules.empty()) installation_.modules = FindModules();
  }

  const std::string& name() const override {
    static const std::string kName = "yade";
    return kName;
  }

  // Asked often, and importing YADE takes half a second or more: remembered for each place.
  Availability availability() const override {
    std::error_code error;
    if (!fs::exists(installation_.python, error)) {
      return {.why_not = fmt::format("there is no {}, the Python that YADE is built for ({})",
                                     installation_.python.string(), kPackage)};
    }
    if (!fs::exists(installation_.modules / "yade/__init__.py", error)) {
      return {.why_not = fmt::format("YADE is not installed ({})", kPackage)};
    }
    static std::mutex mutex;
    static std::map<std::pair<fs::path, fs::path>, Availability> known;
    const std::lock_guard lock(mutex);
    const auto key = std::pair(installation_.python, installation_.modules);
    const auto found = known.find(key);
    if (found != known.end()) return found->second;
    return known[key] = Probe(installation_);
  }

  double Throughput(const Program&) const override { return 1.2e6; }

  std::string ExplainUnsupported(const Program& program) const override {
    return yade::ExplainUnsupported(program);
  }

  Trace Run(const Program& program, const RunContext& context) const override {
    if (const std::string reason = ExplainUnsupported(program); !reason.empty()) {
      return {.outcome = {Reason::unsupported, reason}};
    }
    Packing start;
    try {
      start = Place(program, context.stop);
    } catch (const InputError& error) {
      return {.outcome = {Reason::invalid_input, error.what()}};
    }
    if (start.empty()) return {.outcome = {Reason::cancelled, "stopped on request"}};
    const fs::path& folder = context.work_folder;
    fs::remove_all(folder);  // what an interrupted attempt left must not pass for a result
    fs::create_directories(folder / kDriverFolder);
    WriteWorkFile(folder / yade::kJobFile, yade::MakeJob(program, start));
    for (const yade::DriverFile& file : yade::Driver()) {
      WriteWorkFile(folder / kDriverFolder / file.name, file.text);
    }
    const ProcessResult process = RunProcess(
        {.arguments = {installation_.python.string(), "-I", "-B",
                       fmt::format("{}/main.py", kDriverFolder), installation_.modules.string(),
                       yade::kJobFile, yade::kResultFile},
         .working_directory = folder,
         .environment = {{"OMP_NUM_THREADS", "1"}},
         .time_limit = context.time_limit},
        context.stop);
    Trace trace = yade::ReadTrace(program, folder / yade::kResultFile, process);
    LeaveWorkFolder(context, trace.outcome, process.output);
    return trace;
  }

 private:
  static Packing Place(const Program& program, const std::stop_token& stop) {
    const auto* insert =
        program.stages.empty() ? nullptr : std::get_if<Insert>(&program.stages.front());
    return PlaceParticles(program.particles, program.domain, insert != nullptr ? *insert : Insert{},
                          stop);
  }

  YadeInstallation installation_;
};

}  // namespace

std::unique_ptr<Backend> MakeYadeBackend() { return MakeYadeBackend({}); }

std::unique_ptr<Backend> MakeYadeBackend(const YadeInstallation& installation) {
  return std::make_unique<YadeBackend>(installation);
}

}  // namespace powdercal
