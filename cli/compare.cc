#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <tuple>

#include "cli/commands.h"
#include "cli/compare_source.h"
#include "cli/compare_surrogates.h"
#include "cli/compare_text.h"
#include "cli/output.h"
#include "cli/signals.h"
#include "cli/status_line.h"
#include "cli/text.h"
#include "core/files.h"
#include "core/version.h"
#include "reports/comparison_json.h"
#include "reports/comparison_page.h"
#include "reports/results_json.h"
#include "reports/text.h"
#include "studies/comparison/comparison.h"
#include "studies/comparison/contest_runner.h"
#include "studies/run_directory.h"

namespace powdercal::cli {
namespace {

using namespace comparison;
namespace fs = std::filesystem;

constexpr int kSeeds = 20;
constexpr int kRealSeeds = 3;
constexpr int kDesignPoints = 24;
constexpr const char* kDesignFolder = "design";
constexpr auto kSaveInterval = std::chrono::seconds(5);

struct Options {
  StudyOptions study;
  CompareSurrogatesCommand surrogates;
  std::string optimizers;
  int seeds = 0;  // 0: the default
  std::optional<double> core_seconds;
  std::vector<std::string> emulate;
  bool real = false;
  int design = 0;  // 0: only where there is no finished run
  int hold_out_seeds = 3;
  std::string folder;
  bool json = false;
};

std::uint64_t ParseSeed(const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || stop != end) {
    throw InputError("a whole number is expected",
                     {.location = {"command line"}, .key = "--seed", .value = text});
  }
  return seed;
}

InputError CommandLineError(const std::string& problem, const std::string& key) {
  return InputError(problem, {.location = {"command line"}, .key = key});
}

std::string Quoted(const std::string& word) {
  if (word.find_first_of(" '\"()[]{}*;&|<>$") == std::string::npos) return word;
  return word.find('\'') == std::string::npos ? "'" + word + "'" : "\"" + word + "\"";
}

// The command that repeats the comparison.
std::string CommandOf(const Options& options, const std::vector<std::string>& emulated) {
  std::vector<std::string> words = options.study.Words();
  const auto add = [&](const char* option, const std::string& value) {
    words.insert(words.end(), {option, value});
  };
  if (!options.optimizers.empty()) add("--optimizers", options.optimizers);
  if (options.seeds > 0) add("--seeds", std::to_string(options.seeds));
  if (options.core_seconds) add("--core-seconds", fmt::format("{}", *options.core_seconds));
  if (options.real) words.emplace_back("--real");
  for (const std::string& run : emulated) add("--emulate", run);
  if (options.design > 0) add("--design", std::to_string(options.design));
  if (options.hold_out_seeds != Options().hold_out_seeds) {
    add("--hold-out-seeds", std::to_string(options.hold_out_seeds));
  }
  std::string text = "powdercal compare";
  for (const std::string& word : words) text += " " + Quoted(word);
  return text;
}

void CheckSource(const Options& options, const Study& study) {
  const bool simulates = study.backend.backend->simulates();
  if (options.real && !options.emulate.empty()) {
    throw CommandLineError("--real and --emulate exclude each other", "--real");
  }
  if (options.design > 0 && (options.real || !options.emulate.empty())) {
    throw CommandLineError(
        "is simulated for an emulator of its own; leave out --real and --emulate", "--design");
  }
  if (simulates) return;
  for (const auto& [given, key] :
       {std::pair(options.real, "--real"), std::pair(!options.emulate.empty(), "--emulate"),
        std::pair(options.design > 0, "--design")}) {
    if (!given) continue;
    throw CommandLineError(fmt::format("backend '{}' simulates nothing; it is compared on directly",
                                       study.backend.backend->name()),
                           key);
  }
}

// Everything that one comparison needs, built up step by step.
class Comparing final : public ContestListener {
 public:
  Comparing(const Options& options, Study& study)
      : options_(options),
        study_(study),
        planner_(study),
        field_(study,
               options.optimizers.empty() ? std::vector<std::string>()
                                          : SplitLabels(options.optimizers),
               study.budget.evaluations),
        folder_(options.folder) {
    if (folder_.empty()) {
      folder_ = options.study.DefaultFolder(study);
      folder_ += "-comparison";
    }
  }

  int Run();

  void OnContest(const ContestRecord& record, int done, int all) override;
  void OnRun(const LedgerRun& run) override;
  void OnTick(int done, int all) override {
    if (status_) status_->Show(fmt::format("{}  contests", ProgressBar(done, all)));
  }

 private:
  void ChooseSource();
  void Emulate(const EmulatorData& data, const std::vector<std::string>& runs);
  void OpenFolder();
  void FillSetting();
  void ReadEarlier();
  std::vector<Task> TasksLeft();
  void Hold(const std::vector<Task>& tasks);
  Comparison Result(bool interrupted) const;

  const Options& options_;
  Study& study_;
  Planner planner_;
  Field field_;
  fs::path folder_;
  SignalStop signals_;
  std::unique_ptr<RunDirectory> directory_;
  std::unique_ptr<Ledger> ledger_;
  std::unique_ptr<Emulator> emulator_;
  std::unique_ptr<Oracle> oracle_;  // null: the simulator
  std::unique_ptr<Study> raised_;   // at a higher fidelity
  std::unique_ptr<Planner> raised_planner_;
  Setting setting_;
  std::vector<ContestRecord> earlier_;  // of comparison.json
  std::vector<ContestRecord> records_;  // that count
  std::optional<StatusLine> status_;
  std::chrono::steady_clock::time_point saved_ = std::chrono::steady_clock::now();
};

void Comparing::OpenFolder() {
  directory_ = std::make_unique<RunDirectory>(folder_, "comparison on " + study_.Fingerprint(),
                                              study_.ToYaml(), study_.base_folder);
  ledger_ = std::make_unique<Ledger>(directory_->ledger(), Ledger::Mode::read_write);
}

// All that can be wrong with what was asked for shows here, before anything is written.
void Comparing::ChooseSource() {
  const Backend& backend = *study_.backend.backend;
  setting_.backend = backend.name();
  if (!backend.simulates()) {
    setting_.source = Source::table;
    setting_.source_text = "the table backend";
    setting_.noisy = false;
    oracle_ = MakeTableOracle(planner_);
    return;
  }
  if (options_.real) {
    setting_.source = Source::simulator;
    setting_.source_text =
        fmt::format("simulations with {} {}", backend.name(), planner_.availability().version);
    raised_ = options_.hold_out_seeds > 0 ? RaisedFidelity(study_) : nullptr;
    if (raised_) raised_planner_ = std::make_unique<Planner>(*raised_);
    return;
  }
  std::vector<std::string> runs = options_.emulate;
  if (runs.empty() && options_.design == 0 && !fs::exists(folder_ / kDesignFolder)) {
    const fs::path found = FindFinishedRun(study_, options_.study.DefaultFolder(study_));
    if (!found.empty()) runs.push_back(found.string());
  }
  if (!runs.empty()) Emulate(ReadRuns(study_, runs), runs);
}

void Comparing::Emulate(const EmulatorData& data, const std::vector<std::string>& runs) {
  emulator_ = std::make_unique<Emulator>(study_, data.points);
  oracle_ = MakeEmulatorOracle(*emulator_);
  setting_.source = Source::emulator;
  setting_.source_text = data.text;
  setting_.emulator = emulator_->quality();
  setting_.emulator_points = emulator_->points();
  setting_.emulator_runs = emulator_->runs();
  setting_.emulator_failed_runs = emulator_->failed_runs();
  setting_.warnings = emulator_->warnings();
  setting_.command = {CommandOf(options_, runs)};
}

void Comparing::FillSetting() {
  setting_.study = study_.name;
  setting_.description = study_.description;
  setting_.program_version = kVersion;
  setting_.seeds = options_.seeds > 0                     ? options_.seeds
                   : setting_.source == Source::simulator ? kRealSeeds
                                                          : kSeeds;
  setting_.rules = {.experiments = study_.CalibratedExperiments(),
                    .replicates = study_.backend.replicates,
                    .slots = study_.parallel(),
                    .cores = study_.backend.backend->cores(),
                    .evaluations = study_.budget.evaluations};
  if (options_.core_seconds) setting_.rules.core_seconds = *options_.core_seconds;
  setting_.hold_out_seeds = setting_.noisy ? options_.hold_out_seeds : 0;
  setting_.initial_design = field_.initial_design().name;
  const Objectives objectives = study_.MakeObjectives();
  setting_.targets = static_cast<int>(objectives.targets.size());
  if (objectives.kind == Objectives::Kind::pareto) {
    for (const std::size_t i : study_.CalibratedExperiments()) {
      setting_.objectives.push_back(study_.experiments[i].name());
    }
  }
  setting_.parameters = study_.space.parameters;
  if (setting_.command.empty()) setting_.command = {CommandOf(options_, {})};
}

// What an earlier command has left of the same contests. A file that cannot be read is of another
// version, and is written anew.
void Comparing::ReadEarlier() {
  const fs::path file = directory_->folder() / "comparison.json";
  if (!fs::exists(file)) return;
  try {
    earlier_ = ContestsFromJson(nlohmann::json::parse(ReadFile(file)));
  } catch (const nlohmann::json::exception& error) {
    Say("note: {} cannot be read and is written anew: {}\n", file.string(), error.what());
  } catch (const InputError& error) {
    Say("note: {} cannot be read and is written anew: {}\n", file.string(), error.what());
  }
}

// Seed by seed, so that an interruption leaves whole seeds.
std::vector<Task> Comparing::TasksLeft() {
  const std::string source = oracle_ ? oracle_->fingerprint() : planner_.availability().version;
  std::vector<Task> tasks;
  for (int seed = 1; seed <= setting_.seeds; ++seed) {
    for (const Contestant& contestant : field_.contestants()) {
      Task task{&contestant, seed,
                ContestKey(study_, field_, contestant, seed, setting_.rules, source,
                           setting_.hold_out_seeds)};
      const auto known =
          std::find_if(earlier_.begin(), earlier_.end(),
                       [&](const ContestRecord& record) { return record.key == task.key; });
      if (known == earlier_.end()) {
        tasks.push_back(std::move(task));
      } else {
        records_.push_back(*known);
      }
    }
  }
  return tasks;
}

void Comparing::Hold(const std::vector<Task>& tasks) {
  const ContestOptions options{.rules = setting_.rules,
                               .hold_out_seeds = setting_.hold_out_seeds,
                               .stop = signals_.token(),
                               .listener = this};
  if (oracle_) {
    const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    HoldOnOracle(study_, field_, tasks, *oracle_, options, threads);
  } else {
    HoldOnSimulator(field_, tasks, planner_, raised_planner_.get(), *directory_, *ledger_, options);
  }
}

void Comparing::OnContest(const ContestRecord& record, int done, int all) {
  records_.push_back(record);
  if (!oracle_ || done == all || done % 10 == 0 || !record.error.empty()) {
    const double value = record.steps.empty() ? kNone : ValueAfter(ReportedChi2(record), 1 << 30);
    status_->Line(fmt::format("{:3}/{} {}, seed {}: chi2 {:.3g} after {} evaluations; {}", done,
                              all, record.label, record.seed, value, record.steps.size(),
                              record.end));
  }
  if (std::chrono::steady_clock::now() - saved_ < kSaveInterval) return;
  WriteFileAtomically(directory_->folder() / "comparison.json",
                      JsonText(ComparisonToJson(Result(true))));
  saved_ = std::chrono::steady_clock::now();
}

void Comparing::OnRun(const LedgerRun& run) {
  if (run.outcome.ok()) return;
  status_->Line(fmt::format("        {} failed, {}: {}", run.experiment,
                            ToString(run.outcome.reason), run.outcome.message));
}

Comparison Comparing::Result(bool interrupted) const {
  return Evaluate(setting_, field_, records_, interrupted);
}

int Comparing::Run() {
  ChooseSource();
  OpenFolder();
  if (!oracle_ && !options_.real) {
    const int points = options_.design > 0 ? options_.design : kDesignPoints;
    const EmulatorData data =
        SimulateDesign(study_, points, folder_ / kDesignFolder, signals_.token());
    if (data.interrupted) return kInterrupted;
    Emulate(data, {});
  }
  FillSetting();
  ReadEarlier();
  const std::vector<Task> tasks = TasksLeft();
  Say("powdercal {}: {} optimizers on {}, {} seeds, {} evaluations each; answers from {}\n",
      kVersion, field_.contestants().size(), study_.name, setting_.seeds,
      setting_.rules.evaluations, setting_.source_text);
  if (!records_.empty()) {
    Say("{} of {} contests are known from {}\n", records_.size(), records_.size() + tasks.size(),
        (folder_ / "comparison.json").string());
  }
  for (const std::string& warning : setting_.warnings) Say("warning: {}\n", warning);
  if (!study_.backend.lower_fidelities.empty()) {
    Say("note: backend.lower_fidelities is not used: every optimizer is compared at {}\n",
        ToString(study_.backend.fidelity));
  }
  status_.emplace();
  Hold(tasks);
  status_.reset();
  const bool interrupted = signals_.token().stop_requested();
  // In one order, whichever ended first.
  std::stable_sort(records_.begin(), records_.end(),
                   [](const ContestRecord& a, const ContestRecord& b) {
                     return std::tie(a.seed, a.label) < std::tie(b.seed, b.label);
                   });
  const Comparison comparison = Result(interrupted);
  WriteComparison(comparison, directory_->folder());
  WriteOutput(options_.json ? JsonText(ComparisonToJson(comparison)) : ComparisonText(comparison));
  Say("report: {}\n", (folder_ / "comparison.html").string());
  if (interrupted) return kInterrupted;
  const bool found =
      std::any_of(comparison.standings.begin(), comparison.standings.end(),
                  [](const Standing& one) { return std::isfinite(one.final_value.lower); });
  return found ? kDone : kFellShort;
}

// Of regressions instead of optimizers.
int CompareRegressions(const CLI::App& command, Options& options) {
  if (command.count("study") > 0) {
    throw CommandLineError("takes its evaluations from a run or a file; leave out the study",
                           "--surrogates");
  }
  for (const char* const option : {"--optimizers", "--seeds", "--core-seconds", "--emulate",
                                   "--real", "--design", "--hold-out-seeds"}) {
    if (command.count(option) == 0) continue;
    throw CommandLineError("belongs to a comparison of optimizers, not to --surrogates", option);
  }
  if (const std::string seed = options.study.Given("--seed"); !seed.empty()) {
    options.surrogates.options.seed = ParseSeed(seed);
  }
  options.surrogates.folder = options.folder;
  return CompareSurrogates(options.surrogates, options.json);
}

int Compare(const Options& options) {
  Study study = options.study.Load();
  CheckSource(options, study);
  const Planner planner(study);
  if (!planner.availability().available) {
    throw InputError(fmt::format("backend '{}' is not available: {}", study.backend.backend->name(),
                                 planner.availability().why_not));
  }
  if (const std::string reason = planner.ExplainUnsupported(); !reason.empty()) {
    throw InputError(reason, {.location = {study.file}});
  }
  return Comparing(options, study).Run();
}

void DeclareSource(CLI::App& command, Options& options) {
  command
      .add_option("--emulate", options.emulate,
                  "hold the contests on an emulator fitted to these run folders (default: the "
                  "newest finished run of the study, else a design that is simulated first)")
      ->type_name("RUN,…")
      ->delimiter(',')
      ->check(NotEmpty);
  command.add_flag("--real", options.real, "simulate every evaluation");
  command
      .add_option("--design", options.design,
                  "simulate a Sobol' design of so many points first, and emulate that (default "
                  "without a finished run: " +
                      std::to_string(kDesignPoints) + ")")
      ->type_name("N")
      ->check(CLI::Range(static_cast<int>(Emulator::kFewestPoints), 100'000));
}

}  // namespace

void AddCompare(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "compare",
      "Optimizers against each other on a study: same budget, same initial design, many seeds. "
      "With --surrogates: regressions on known evaluations.");
  auto options = std::make_shared<Options>();
  options->study.Declare(*command, false);
  options->surrogates.Declare(*command);
  command
      ->add_option("--optimizers", options->optimizers,
                   "who takes part, with options where wanted: bayesian:acquisition=ei,random "
                   "(default: every optimizer that can treat the study)")
      ->type_name("NAME,…")
      ->check(NotEmpty);
  command
      ->add_option(
          "--seeds", options->seeds,
          fmt::format("of the optimizers and initial designs (default: {}, with --real {})", kSeeds,
                      kRealSeeds))
      ->type_name("N")
      ->check(CLI::Range(1, 10'000));
  command
      ->add_option("--core-seconds", options->core_seconds,
                   "budget of simulated core-seconds, besides that of evaluations")
      ->type_name("S")
      ->check(CLI::PositiveNumber);
  DeclareSource(*command, *options);
  command
      ->add_option("--hold-out-seeds", options->hold_out_seeds,
                   "fresh particle seeds on which the reported points are simulated again; 0: not")
      ->type_name("N")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      ->add_option(
          "--out", options->folder,
          "folder of the comparison (default: runs/NAME-comparison); the same command goes "
          "on there")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "print comparison.json to standard output");
  command->callback([command, options, &status] {
    if (!options->surrogates.source.empty()) {
      status = CompareRegressions(*command, *options);
      return;
    }
    if (command->count("study") == 0) throw CLI::RequiredError("STUDY or --surrogates");
    status = Compare(*options);
  });
}

}  // namespace powdercal::cli
