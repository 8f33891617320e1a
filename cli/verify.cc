#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <thread>

#include "backends/registry.h"
#include "cli/commands.h"
#include "cli/ladder_text.h"
#include "cli/output.h"
#include "cli/parameters.h"
#include "cli/signals.h"
#include "cli/status_line.h"
#include "core/files.h"
#include "core/quantity.h"
#include "core/version.h"
#include "reports/results_json.h"
#include "reports/text.h"
#include "reports/verification_page.h"
#include "studies/run_directory.h"
#include "studies/runner.h"
#include "verification/ladder.h"
#include "verification/ladder_json.h"
#include "verification/packing_rung.h"
#include "verification/study_rungs.h"

namespace powdercal::cli {
namespace {

using namespace verification;
namespace fs = std::filesystem;

struct Options {
  StudyOptions study;
  std::string law;
  std::vector<std::string> backends;
  std::vector<std::string> rungs;
  std::vector<std::string> parameters;
  std::vector<std::string> margins;
  int seeds = LadderOptions().seeds;
  std::string folder;
  bool json = false;
};

// A line for each failure and, beyond the first rung, for each run; on a terminal a status below.
class LadderDisplay final : public RunListener {
 public:
  void OnRung(Rung rung, int runs, int known) override {
    rung_ = rung;
    status_.Line(fmt::format("rung {}, {}: {} runs{}", static_cast<int>(rung) + 1, ToString(rung),
                             runs,
                             known > 0 ? fmt::format(", {} of them in the ledger", known) : ""));
  }
  void OnRun(const Job& job, const LedgerRun& run, int done, int all) override {
    if (!run.outcome.ok()) {
      status_.Line(fmt::format("        {} in {} failed, {}: {}", job.name, run.backend,
                               ToString(run.outcome.reason), run.outcome.message));
    } else if (rung_ != Rung::contact) {
      status_.Line(fmt::format("{:3}/{} {} in {}: ok, {}", done, all, job.name, run.backend,
                               DurationText(run.diagnostics.wall_seconds)));
    }
  }
  void OnTick(int done, int all) override {
    status_.Show(fmt::format("{}  {}", ProgressBar(done, all), ToString(rung_)));
  }

 private:
  StatusLine status_;
  Rung rung_ = Rung::contact;
};

InputError CommandLineError(const std::string& problem, const std::string& key,
                            const std::string& value = "") {
  return InputError(problem, {.location = {"command line"}, .key = key, .value = value});
}

// Names or numbers, ascending; without any: all that the subject has.
std::vector<Rung> ReadRungs(const std::vector<std::string>& texts) {
  std::vector<Rung> rungs;
  const auto names = RungNames();
  for (const std::string& text : texts) {
    auto found = std::find(names.begin(), names.end(), text);
    if (text.size() == 1 && text[0] >= '1' && text[0] < '1' + static_cast<int>(names.size())) {
      found = names.begin() + (text[0] - '1');
    }
    if (found == names.end()) {
      throw UnknownName("rung", text, names, {.location = {"command line"}, .key = "--rungs"});
    }
    rungs.push_back(static_cast<Rung>(found - names.begin()));
  }
  std::sort(rungs.begin(), rungs.end());
  rungs.erase(std::unique(rungs.begin(), rungs.end()), rungs.end());
  return rungs;
}

std::vector<std::string> Simulators() {
  std::vector<std::string> names;
  for (const std::string& name : BackendNames()) {
    if (MakeBackend(name)->simulates()) names.push_back(name);
  }
  return names;
}

// Those that were asked for, or all simulators; the study's own is used with its options, and comes
// first by default.
struct Backends {
  std::vector<std::unique_ptr<Backend>> owned;
  std::vector<Contender> contenders;
};

Backends MakeBackends(const std::vector<std::string>& given, const Study* study) {
  const std::vector<std::string> known = Simulators();
  const std::string own = study != nullptr ? study->backend.backend->name() : "";
  std::vector<std::string> names = given.empty() ? known : given;
  if (given.empty()) {
    std::stable_partition(names.begin(), names.end(),
                          [&](const std::string& name) { return name == own; });
  }
  Backends backends;
  for (auto name = names.begin(); name != names.end(); ++name) {
    const InputError::Details details{.location = {"command line"}, .key = "--backends"};
    if (std::find(known.begin(), known.end(), *name) == known.end()) {
      throw UnknownName("simulator", *name, known, details);
    }
    if (std::find(names.begin(), name, *name) != name) {
      throw CommandLineError("given twice", "--backends", *name);
    }
    if (*name == own) {
      backends.contenders.emplace_back(*study->backend.backend);
    } else {
      backends.owned.push_back(MakeBackend(*name));
      backends.owned.back()->Prepare({});
      backends.contenders.emplace_back(*backends.owned.back());
    }
  }
  if (names.size() < 2) throw CommandLineError("needs two backends at least", "--backends");
  return backends;
}

int ReadParallel(const std::string& text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0 || value > 1024) {
    throw CommandLineError("expected a number from 0 to 1024", "--parallel", text);
  }
  return value;
}

double ReadSeconds(const std::string& text, const std::string& key) {
  double value = 0;
  try {
    value = ParseQuantity(text, "s");
  } catch (const InputError& error) {
    throw CommandLineError(error.problem(), key, text);
  }
  if (value <= 0) throw CommandLineError("must be above 0 s", key, text);
  return value;
}

// What is verified, and everything it refers to.
struct Task {
  std::unique_ptr<Study> study;  // null: a law alone
  std::unique_ptr<Planner> planner;
  LadderSubject subject;
  std::string fingerprint;  // of the subject
  int parallel = 0;
  std::optional<std::chrono::duration<double>> time_limit;
};

// The best point of a run folder.
std::vector<double> BestPoint(Study& study, const fs::path& folder, std::string& source) {
  const StudyResults results =
      CollectResults(study, Ledger(folder / "ledger.sqlite", Ledger::Mode::read_only));
  if (!results.best) {
    throw InputError("the run has no best point; give parameters with -p",
                     {.location = {folder.string()}});
  }
  const EvaluationResult& best = results.history[*results.best];
  source = fmt::format("the best point, #{}, of {} ({})", best.id, folder.string(), results.state);
  std::vector<double> values;
  for (const Parameter& parameter : study.space.parameters) {
    values.push_back(best.parameters.at(parameter.name));
  }
  return values;
}

// The law as the first experiment that can be planned simulates it.
Subject SubjectOf(const Planner& planner, const std::vector<double>& parameters) {
  const Study& study = planner.study();
  std::string reason = "the study has no experiment";
  std::optional<Subject> subject;
  for (std::size_t i = 0; i < study.experiments.size() && !subject; ++i) {
    if (const std::string why = planner.ExplainUnplanned(i); !why.empty()) {
      reason = why;
      continue;
    }
    const Program program = planner.PlanExperiment(i, parameters, 0).program;
    subject = Subject{.name = study.name,
                      .description = study.description,
                      .law = program.law,
                      .materials = program.materials,
                      .sizes = study.powder.sizes,
                      .time_step = program.time_step,
                      // That of the shipped laws against their E, unless an experiment has one.
                      .stress = 1.8e-4 * program.materials.young_modulus};
    for (const Stage& stage : program.stages) {
      if (const auto* servo = std::get_if<Servo>(&stage)) subject->stress = servo->stress;
    }
  }
  if (!subject) throw InputError(reason, {.location = {study.file}});
  return *subject;
}

Task ReadStudy(const Options& options) {
  Task task;
  const fs::path path = options.study.file();
  const bool folder = fs::is_directory(path);
  if (folder) {
    const auto others = options.study.GivenOptions({"--parallel", "--run-timeout"});
    if (!others.empty()) {
      throw CommandLineError("changes the study, which a run folder has already", others.front());
    }
    task.study = std::make_unique<Study>(LoadFromFolder(path));
  } else {
    task.study = std::make_unique<Study>(options.study.Load());
  }
  LadderSubject& subject = task.subject;
  if (!options.parameters.empty()) {
    subject.parameters = ReadParameters(*task.study, options.parameters);
    subject.parameters_source = "the command line";
  } else if (folder) {
    subject.parameters = BestPoint(*task.study, path, subject.parameters_source);
  }
  task.planner = std::make_unique<Planner>(*task.study);
  subject.planner = task.planner.get();
  const bool point = !subject.parameters.empty();
  if (!point) subject.parameters_source = "the centre of the study's ranges; rungs 1 and 2 only";
  subject.law = SubjectOf(*task.planner, point ? subject.parameters : task.planner->Centre());
  task.fingerprint = "verification of study " + task.study->Fingerprint();
  task.parallel = task.study->parallel();
  if (const auto& limit = task.study->budget.run_timeout) {
    task.time_limit = std::chrono::duration<double>(*limit);
  }
  return task;
}

Task ReadLaw(const Options& options) {
  if (!options.parameters.empty()) {
    throw CommandLineError("needs a study: a law alone has no free parameters", "-p");
  }
  const auto others = options.study.GivenOptions({"--parallel", "--run-timeout"});
  if (!others.empty()) throw CommandLineError("needs a study", others.front());
  Task task{.subject = {.law = ShippedLaw(options.law)}};
  task.fingerprint = "verification of law " + options.law;
  return task;
}

Task ReadTask(const Options& options) {
  if (options.law.empty() == options.study.file().empty()) {
    throw InputError(
        fmt::format("give either a study, or a law with --law ({})", JoinNames(LawNames())),
        {.location = {"command line"}});
  }
  Task task = options.law.empty() ? ReadStudy(options) : ReadLaw(options);
  const std::string parallel = options.study.Given("--parallel");
  const std::string limit = options.study.Given("--run-timeout");
  if (!parallel.empty()) task.parallel = ReadParallel(parallel);
  if (!limit.empty()) {
    task.time_limit = std::chrono::duration<double>(ReadSeconds(limit, "--run-timeout"));
  }
  if (task.parallel == 0) {
    task.parallel = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }
  return task;
}

// "void_ratio=0.01", "shear.cohesion=20 Pa".
std::map<std::string, double> ReadMargins(const std::vector<std::string>& texts, const Task& task) {
  std::map<std::string, std::string> units;
  if (task.study) units = ExperimentQuantities(*task.study);
  for (const std::string& name : PackingQuantities()) units[name] = "1";
  std::map<std::string, double> margins;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw CommandLineError("expected --margin NAME=VALUE", "--margin", text);
    }
    const std::string name = text.substr(0, equals);
    const auto unit = units.find(name);
    if (unit == units.end()) {
      std::vector<std::string> known;
      for (const auto& [key, ignored] : units) known.push_back(key);
      throw UnknownName("quantity", name, known, {.location = {"command line"}, .key = "--margin"});
    }
    double value = 0;
    try {
      const powdercal::Quantity quantity = powdercal::Quantity::Parse(text.substr(equals + 1));
      value = quantity.dimension.dimensionless()
                  ? quantity.si
                  : ParseQuantity(text.substr(equals + 1), unit->second);
    } catch (const InputError& error) {
      throw CommandLineError(error.problem(), "--margin", text);
    }
    if (!(value > 0)) throw CommandLineError("must be above 0", "--margin", text);
    if (!margins.emplace(name, value).second) {
      throw CommandLineError("given twice", "--margin", name);
    }
  }
  return margins;
}

LadderOptions ReadLadder(const Options& options, const Task& task) {
  LadderOptions ladder{.seeds = options.seeds, .margins = ReadMargins(options.margins, task)};
  const bool point = !task.subject.parameters.empty();
  ladder.rungs = ReadRungs(options.rungs);
  if (ladder.rungs.empty()) {
    ladder.rungs = {Rung::contact, Rung::packing};
    if (point) ladder.rungs.insert(ladder.rungs.end(), {Rung::experiment, Rung::calibration});
    if (task.study && !point) {
      Say("note: rungs 3 and 4 need parameters (-p NAME=VALUE), or a run folder instead of the "
          "study\n");
    }
  }
  for (const Rung rung : ladder.rungs) {
    if (rung == Rung::contact || rung == Rung::packing || point) continue;
    throw CommandLineError(
        task.study ? fmt::format("rung '{}' needs parameters: give -p NAME=VALUE, or a run folder "
                                 "instead of the study",
                                 ToString(rung))
                   : fmt::format("rung '{}' needs a study: a law alone has no experiments",
                                 ToString(rung)),
        "--rungs");
  }
  return ladder;
}

int Verify(const Options& options) {
  Task task = ReadTask(options);
  const LadderOptions ladder = ReadLadder(options, task);
  const Backends backends = MakeBackends(options.backends, task.study.get());

  SignalStop signals;
  std::unique_ptr<RunDirectory> directory;
  std::unique_ptr<Ledger> ledger;
  fs::path work_folder;
  if (options.folder.empty()) {
    work_folder = MakeTemporaryFolder();
  } else {
    directory = std::make_unique<RunDirectory>(options.folder, task.fingerprint,
                                               task.study ? task.study->ToYaml() : "");
    ledger = std::make_unique<Ledger>(directory->ledger(), Ledger::Mode::read_write);
    work_folder = directory->folder() / "runs";
    fs::create_directories(work_folder);
  }
  LadderReport report;
  {
    LadderDisplay display;
    report = ClimbLadder(task.subject, backends.contenders, ladder,
                         {.parallel = task.parallel,
                          .time_limit = task.time_limit,
                          .work_folder = work_folder,
                          .stop = signals.token(),
                          .listener = &display,
                          .ledger = ledger.get()});
  }
  if (directory) WriteVerification(report, directory->folder());
  WriteOutput(options.json ? JsonText(LadderToJson(report)) : LadderText(report));
  if (directory) Say("report: {}\n", (directory->folder() / "verification.html").string());
  if (report.failures.empty()) {
    std::error_code ignored;
    fs::remove_all(work_folder, ignored);
  } else {
    Say("files of failed runs: {}\n", work_folder.string());
  }
  if (report.interrupted) return kInterrupted;
  return report.passed() ? kDone : kFellShort;
}

}  // namespace

void AddVerify(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand(
      "verify",
      "Compare backends, from two spheres to a whole calibration: a ladder with a verdict on each "
      "rung.");
  auto options = std::make_shared<Options>();
  options->study.Declare(*command, false);
  command
      ->add_option("--law", options->law,
                   "a contact law instead of a study: " + JoinNames(LawNames()))
      ->type_name("NAME")
      ->check(NotEmpty);
  command
      ->add_option("--backends", options->backends,
                   "two or more, the first being the reference (default: all simulators)")
      ->type_name("NAME,…")
      ->delimiter(',')
      ->check(NotEmpty);
  command
      ->add_option("--rungs", options->rungs,
                   "numbers or names: 1 contact, 2 packing, 3 experiment, 4 calibration")
      ->type_name("RUNG,…")
      ->delimiter(',')
      ->check(NotEmpty);
  command->add_option("--seeds", options->seeds, "particle seeds of each case from rung 2 on")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  command
      ->add_option("-p,--parameter", options->parameters,
                   "value of a free parameter by name or symbol, as in `powdercal simulate`")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command
      ->add_option("--margin", options->margins,
                   "margin of equivalence of a quantity, e.g. --margin void_ratio=0.01; may be "
                   "repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--out", options->folder,
          "keep the runs, the verdicts and a page of them in this folder; the same command "
          "goes on there")
      ->type_name("FOLDER")
      ->check(NotEmpty);
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] { status = Verify(*options); });
}

}  // namespace powdercal::cli
