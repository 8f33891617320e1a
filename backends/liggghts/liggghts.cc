#include "backends/liggghts/liggghts.h"

#include <fmt/format.h>

#include <map>
#include <mutex>
#include <system_error>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/result.h"
#include "backends/work_folder.h"
#include "core/errors.h"
#include "core/process.h"

namespace powdercal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "liggghts";

// Open MPI would otherwise start a daemon outside our process group, which nothing would end; and
// processes would share a folder for their session, which one removes while another begins.
const std::vector<std::pair<std::string, std::string>> kEnvironment = {
    {"OMPI_MCA_ess_singleton_isolated", "1"},
    {"OMPI_MCA_orte_create_session_dirs", "0"},
    {"OMPI_ALLOW_RUN_AS_ROOT", "1"},
    {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
    {"OMP_NUM_THREADS", "1"}};

Availability Probe(const fs::path& program) {
  const ProcessResult result = RunProcess({.arguments = {program.string(), "-log", "none", "-h"},
                                           .environment = kEnvironment,
                                           .time_limit = std::chrono::seconds(30)});
  static constexpr std::string_view kMark = "LIGGGHTS-PUBLIC ";
  const std::size_t begin = result.output.find(kMark);
  if (begin == std::string::npos) {
    return {.why_not = fmt::format("{} does not answer as LIGGGHTS-PUBLIC does ({})",
                                   program.string(), result.Describe())};
  }
  const std::size_t start = begin + kMark.size();
  const std::size_t end = result.output.find_first_of(", )\n", start);
  return {.available = true, .version = result.output.substr(start, end - start)};
}

class LiggghtsBackend final : public Backend {
 public:
  const std::string& name() const override {
    static const std::string kName = "liggghts";
    return kName;
  }

  // Asked often, and starting the program costs a third of a second: remembered for each file.
  Availability availability() const override {
    const fs::path program = FindProgram(kProgram);
    if (program.empty()) {
      return {.why_not = "no program 'liggghts' on PATH (Debian: apt-get install liggghts)"};
    }
    static std::mutex mutex;
    static std::map<fs::path, Availability> known;
    const std::lock_guard lock(mutex);
    const auto found = known.find(program);
    if (found != known.end()) return found->second;
    return known[program] = Probe(program);
  }

  double Throughput(const Program&) const override { return 5.5e6; }

  std::string ExplainUnsupported(const Program& program) const override {
    return liggghts::ExplainUnsupported(program);
  }

  Trace Run(const Program& program, const RunContext& context) const override {
    if (const std::string reason = ExplainUnsupported(program); !reason.empty()) {
      return {.outcome = {Reason::unsupported, reason}};
    }
    liggghts::Input input;
    try {
      input = liggghts::WriteInput(program);
    } catch (const InputError& error) {
      return {.outcome = {Reason::invalid_input, error.what()}};
    }
    const fs::path& folder = context.work_folder;
    fs::remove_all(folder);  // what an interrupted attempt left must not pass for a result
    fs::create_directories(folder);
    WriteWorkFile(folder / liggghts::kDeckFile, input.deck);
    for (const auto& [name, text] : input.files) WriteWorkFile(folder / name, text);
    const ProcessResult process = liggghts::RunDeck(folder, context.time_limit, context.stop);
    Trace trace = liggghts::ReadTrace(program, input.particle_count, folder, process);
    LeaveWorkFolder(context, trace.outcome, process.output);
    return trace;
  }
};

}  // namespace

ProcessResult liggghts::RunDeck(const fs::path& folder,
                                std::optional<std::chrono::duration<double>> time_limit,
                                std::stop_token stop) {
  // "-screen none" crashes with a mesh: always to a file.
  return RunProcess(
      {.arguments = {kProgram, "-in", kDeckFile, "-log", "none", "-screen", kScreenFile},
       .working_directory = folder,
       .environment = kEnvironment,
       .time_limit = time_limit},
      std::move(stop));
}

std::unique_ptr<Backend> MakeLiggghtsBackend() { return std::make_unique<LiggghtsBackend>(); }

}  // namespace powdercal
