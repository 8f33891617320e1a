#include "studies/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

#include "backends/registry.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/quantity.h"
#include "studies/fidelities.h"

namespace powdercal {
namespace {

constexpr const char* kDefaultBackend = "embedded";

// Of a study in a sub-folder, its own name alone is near enough.
std::string NearestStudy(const std::string& name, const std::vector<std::string>& names) {
  if (std::string nearest = NearestName(name, names); !nearest.empty()) return nearest;
  const auto own_name = [](const std::filesystem::path& path) { return path.filename().string(); };
  std::vector<std::string> own_names;
  for (const std::string& one : names) own_names.push_back(own_name(one));
  const std::string nearest = NearestName(own_name(name), own_names);
  const auto found = std::find(own_names.begin(), own_names.end(), nearest);
  return found == own_names.end() ? "" : names[static_cast<std::size_t>(found - own_names.begin())];
}

std::vector<std::string> FreeParameterNames() {
  std::vector<std::string> names;
  for (const FreeParameter& parameter : FreeParameters()) names.push_back(parameter.name);
  return names;
}

// Of a parameter that is one of several names.
void SerializeChoices(Archive& archive, Parameter& parameter, const FreeParameter& known) {
  if (archive.reading()) {
    parameter = {.name = known.name,
                 .symbol = known.symbol,
                 .unit = known.unit,
                 .kind = Parameter::Kind::categorical};
    if (archive.Has("range")) {
      throw archive.ErrorAt("range", fmt::format("'{}' has `choices`, out of {}", known.name,
                                                 JoinNames(known.categories)));
    }
  }
  archive.Text("symbol", parameter.symbol);
  archive.Require("choices");
  archive.Names("choices", parameter.categories, known.description, known.categories);
  if (!archive.reading()) return;
  if (parameter.categories.size() < 2) {
    throw archive.ErrorAt("choices", fmt::format("at least two of {} are needed to choose from",
                                                 JoinNames(known.categories)));
  }
  parameter.upper = static_cast<double>(parameter.categories.size()) - 1;
}

// `range` holds bare numbers in `unit`, which may be left out for pure numbers only.
void SerializeParameter(Archive& archive, Parameter& parameter, const FreeParameter& known) {
  if (archive.reading()) {
    parameter = {.name = known.name, .symbol = known.symbol, .unit = known.unit};
  }
  archive.Text("symbol", parameter.symbol);
  std::string unit_text = known.unit;
  if (archive.reading() && known.unit != "1" && !archive.Has("unit")) {
    throw archive.ErrorAt("unit",
                          fmt::format("missing unit of the range; expected a {} (such as {})",
                                      Unit::Parse(known.unit).dimension().Name(), known.unit));
  }
  archive.Text("unit", unit_text);
  Unit unit;
  try {
    unit = Unit::Parse(unit_text);
    ParseQuantity("1 " + unit_text, known.unit);
  } catch (const InputError& error) {
    throw archive.ErrorAt("unit", error.problem());
  }
  archive.Require("range");
  archive.Interval("range", parameter.lower, parameter.upper);
  std::string scale = parameter.logarithmic ? "log" : "linear";
  static const std::vector<std::string> kScales = {"linear", "log"};
  archive.Choice("scale", scale, "scale", kScales);
  if (!archive.reading()) return;
  parameter.lower *= unit.to_si();
  parameter.upper *= unit.to_si();
  parameter.logarithmic = scale == "log";
  if (parameter.lower < 0) throw archive.ErrorAt("range", "the lower bound is negative");
  if (parameter.logarithmic && parameter.lower <= 0) {
    throw archive.ErrorAt("range", "a log scale needs a lower bound above zero");
  }
  if (known.name == "restitution" && (parameter.lower <= 0 || parameter.upper > 1)) {
    throw archive.ErrorAt("range", "a restitution lies in (0, 1]");
  }
}

void SerializeParameters(Archive& archive, SearchSpace& space) {
  archive.Require("parameters");
  std::vector<std::string> keys;
  for (const Parameter& parameter : space.parameters) keys.push_back(parameter.name);
  std::size_t index = 0;
  archive.Map("parameters", keys, [&](const std::string& name, Archive& section) {
    const auto known = std::find_if(FreeParameters().begin(), FreeParameters().end(),
                                    [&](const FreeParameter& p) { return p.name == name; });
    if (known == FreeParameters().end()) {
      throw UnknownName("parameter", name, FreeParameterNames(),
                        {.location = section.LocationOf(""), .key = "parameters"});
    }
    if (section.reading()) space.parameters.emplace_back();
    Parameter& parameter = space.parameters[index++];
    if (known->categories.empty()) {
      SerializeParameter(section, parameter, *known);
    } else {
      SerializeChoices(section, parameter, *known);
    }
  });
  if (space.parameters.empty()) {
    throw archive.ErrorAt("parameters", "a study needs at least one parameter to find");
  }
}

void SerializeConfirmation(Archive& section, BackendSpecification& backend) {
  std::vector<std::string> names;
  for (const auto& other : backend.confirm_with) names.push_back(other->name());
  section.Names("confirm_with", names, "backend", BackendNames());
  if (!section.reading()) return;
  for (const std::string& name : names) {
    if (name == backend.backend->name()) {
      throw section.ErrorAt("confirm_with",
                            fmt::format("'{}' is the backend of the study itself", name));
    }
    backend.confirm_with.push_back(MakeBackend(name));
    if (backend.confirm_with.back()->simulates()) continue;
    throw section.ErrorAt("confirm_with",
                          fmt::format("'{}' simulates nothing, and can confirm nothing", name));
  }
}

void SerializeLowerFidelities(Archive& section, BackendSpecification& backend) {
  const auto all = FidelityNames();
  std::vector<std::string> names;
  for (const Fidelity one : backend.lower_fidelities) {
    names.push_back(ToString(one));
  }
  if (section.reading() || !names.empty()) {
    section.Names("lower_fidelities", names, "fidelity", all);
  }
  if (!section.reading()) return;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (std::find(names.begin(), names.end(), all[i]) == names.end()) continue;
    if (static_cast<Fidelity>(i) >= backend.fidelity) {
      throw section.ErrorAt("lower_fidelities",
                            fmt::format("'{}' is not below the study's fidelity '{}'", all[i],
                                        all[static_cast<std::size_t>(backend.fidelity)]));
    }
    backend.lower_fidelities.push_back(static_cast<Fidelity>(i));
  }
}

// `calibration_only`: when writing, without what comes after the search.
void SerializeBackend(Archive& archive, BackendSpecification& backend, bool calibration_only) {
  if (archive.reading()) backend.backend = MakeBackend(kDefaultBackend);
  archive.Section(
      "backend",
      [&](Archive& section) {
        std::string name = backend.backend->name();
        section.Choice("name", name, "backend", BackendNames());
        if (section.reading()) backend.backend = MakeBackend(name);
        section.Enumeration("fidelity", backend.fidelity, "fidelity", FidelityNames());
        if (backend.backend->simulates()) {
          SerializeLowerFidelities(section, backend);
          section.Integer("replicates", backend.replicates, {.lower = 1, .upper = 1000});
          if (section.reading()) {
            backend.confirm_replicates = std::max(backend.confirm_replicates, backend.replicates);
          }
          section.Integer("confirm_replicates", backend.confirm_replicates,
                          {.lower = static_cast<double>(backend.replicates), .upper = 1000});
          if (!calibration_only) SerializeConfirmation(section, backend);
        } else {
          const auto refuse = [&](const char* key, const char* what) {
            if (!section.Has(key)) return;
            throw section.ErrorAt(
                key, fmt::format("'{}' simulates nothing that {}", backend.backend->name(), what));
          };
          refuse("confirm_with", "another backend could confirm");
          refuse("lower_fidelities", "could be simulated at a lower fidelity");
          backend.replicates = backend.confirm_replicates = 1;  // nothing depends on particle seeds
        }
        backend.backend->Serialize(section);
      },
      "name");
}

void SerializeOptimizer(Archive& archive, std::unique_ptr<OptimizerFactory>& optimizer,
                        const SearchSpace& space) {
  if (archive.reading()) optimizer = MakeOptimizerFactory("bayesian");
  archive.Section(
      "optimizer",
      [&](Archive& section) {
        std::string name = optimizer->name();
        section.Choice("name", name, "optimizer", OptimizerNames());
        if (section.reading()) optimizer = MakeOptimizerFactory(name);
        optimizer->Serialize(section, space);
      },
      "name");
}

// Where the law of rolling friction is searched for, `law` has one of the choices.
void SettleRollingModel(Study& study) {
  for (const Parameter& parameter : study.space.parameters) {
    if (parameter.name != "rolling_model") continue;
    const std::string given = RollingNames()[static_cast<std::size_t>(study.law.rolling)];
    const auto& choices = parameter.categories;
    if (std::find(choices.begin(), choices.end(), given) != choices.end()) return;
    if (study.law.rolling != ContactLaw{}.rolling) {
      study.warnings.push_back(
          fmt::format("contact_law.rolling: {} has no effect, parameters.rolling_model is searched "
                      "over {}",
                      given, JoinNames(choices)));
    }
    study.law = study.LawAt(std::vector<double>(study.space.parameters.size(), 0.0));
  }
}

// The study but for its budget: what determines the results.
void SerializeProblem(Archive& archive, Study& study, bool calibration_only = false) {
  archive.Require("study");
  archive.Text("study", study.name);
  archive.Text("description", study.description);
  auto seed = static_cast<std::int64_t>(study.seed);
  archive.Integer("seed", seed, kNonNegative);
  study.seed = static_cast<std::uint64_t>(seed);
  archive.Require("material");
  archive.Section("material", [&](Archive& section) { study.powder.Serialize(section); });
  archive.Section("contact_law",
                  [&](Archive& section) { SerializeContactLaw(section, study.law); });
  if (archive.reading() || study.approximations.any()) {
    archive.Section("approximate",
                    [&](Archive& section) { study.approximations.Serialize(section, study.law); });
  }
  SerializeParameters(archive, study.space);
  if (archive.reading()) SettleRollingModel(study);
  SerializeScaling(archive, study.scaling);
  archive.Section("numerics", [&](Archive& section) { study.numerics.Serialize(section); });
  SerializeExperiments(archive, study.experiments, study.base_folder, calibration_only);
  static const std::vector<std::string> kObjectives = {"joint", "pareto"};
  archive.Enumeration("objective", study.objective, "objective", kObjectives);
  SerializeOptimizer(archive, study.optimizer, study.space);
  SerializeBackend(archive, study.backend, calibration_only);
}

void SerializeStudy(Archive& archive, Study& study) {
  SerializeProblem(archive, study);
  archive.Section("budget", [&](Archive& section) { study.budget.Serialize(section); });
}

// Contradictions between sections.
void CheckConsistency(const Study& study, const Archive& archive) {
  const auto frees = [&](const std::string& name) {
    return std::any_of(study.space.parameters.begin(), study.space.parameters.end(),
                       [&](const Parameter& p) { return p.name == name; });
  };
  const auto needs = [&](const std::string& parameter, bool used, const std::string& law) {
    if (!frees(parameter) || used) return;
    throw archive.ErrorAt("parameters",
                          fmt::format("'{}' has no effect: contact_law has {}", parameter, law));
  };
  const ContactLaw& law = study.law;
  needs("cohesion_energy_density", law.cohesion == ContactLaw::Cohesion::sjkr2,
        "no cohesion: sjkr2");
  needs("surface_energy", law.cohesion == ContactLaw::Cohesion::dmt, "no cohesion: dmt");
  needs("rolling_friction", law.rolling != ContactLaw::Rolling::none || frees("rolling_model"),
        "rolling: none");
  for (const Parameter& parameter : study.space.parameters) {
    if (!parameter.categorical() || study.backend.backend->simulates()) continue;
    throw archive.ErrorAt("parameters",
                          fmt::format("'{}' is a choice of names, and backend '{}' knows numbers "
                                      "only; use a backend that simulates",
                                      parameter.name, study.backend.backend->name()));
  }
  if (study.approximations.any() && !study.backend.backend->simulates()) {
    throw archive.ErrorAt("approximate", fmt::format("backend '{}' simulates nothing that could be "
                                                     "approximated",
                                                     study.backend.backend->name()));
  }
  if (study.CalibratedExperiments().empty()) {
    throw archive.ErrorAt("experiments",
                          "nothing to calibrate against: no experiment is 'observed' without "
                          "'calibrate: false'");
  }
  if (!study.backend.lower_fidelities.empty() && study.optimizer->fidelities() == nullptr) {
    throw archive.ErrorAt("backend",
                          fmt::format("lower_fidelities: optimizer '{}' cannot choose between "
                                      "fidelities; use bayesian, or leave the key out",
                                      study.optimizer->name()));
  }
  if (std::vector<FidelityLevel>* levels = study.optimizer->fidelities()) {
    // What they cost is for later, when programs can be planned.
    for (const double s : LowerFidelityCoordinates(study)) levels->push_back({s, s});
    if (!levels->empty()) levels->push_back({1, 1});
  }
  const std::string reason = study.optimizer->Make(study.space, study.MakeObjectives(), study.seed)
                                 ->ExplainUnsupported(study.space, study.MakeObjectives());
  if (!reason.empty()) throw archive.ErrorAt("optimizer", reason);
  if (study.optimizer->fidelities() != nullptr) study.optimizer->fidelities()->clear();
}

int Cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

// Runs of several threads each, more of them than there is room for.
void WarnOfCrowding(Study& study) {
  const int each = study.backend.backend->cores();
  const int all = study.budget.parallel * each;
  if (each == 1 || each > Cores() || all <= Cores()) return;
  study.warnings.push_back(
      fmt::format("budget.parallel: {} runs of {} threads each are slower on {} cores than {}",
                  study.budget.parallel, each, Cores(), Cores() / each));
}

const std::string& UnitOf(const StudyExperiment& entry, const ObservedResponse& observed) {
  const auto responses = entry.experiment->responses();
  return std::find_if(responses.begin(), responses.end(),
                      [&](const ResponseDescription& r) { return r.name == observed.response; })
      ->unit;
}

// Also told of what is only compared with: `--evaluate-also` may ask for it.
std::vector<std::string> PrepareBackend(Study& study) {
  BackendProblem problem{.base_folder = study.base_folder};
  for (const Parameter& p : study.space.parameters) {
    problem.parameters.push_back({p.name, p.unit, p.lower, p.upper});
  }
  for (const StudyExperiment& entry : study.experiments) {
    for (const ObservedResponse& observed : entry.observed) {
      problem.responses.push_back(
          {entry.name() + "." + observed.response, UnitOf(entry, observed)});
    }
  }
  std::vector<std::string> warnings = study.backend.backend->Prepare(problem);
  for (const auto& other : study.backend.confirm_with) {
    for (const std::string& text : other->Prepare(problem)) {
      warnings.push_back(fmt::format("{}: {}", other->name(), text));
    }
  }
  return warnings;
}

}  // namespace

void Budget::Serialize(Archive& archive) {
  archive.Integer("evaluations", evaluations, {.lower = 1});
  archive.Integer("parallel", parallel, {.lower = 0, .upper = 1024});
  archive.Quantity("wall_time", wall_time, "s", kPositive);
  archive.Quantity("run_timeout", run_timeout, "s", kPositive);
  archive.Flag("deterministic", deterministic);
  archive.Flag("keep_files", keep_files);
}

Study Study::Parse(const std::string& text, const std::string& file,
                   const std::filesystem::path& base_folder, const Overrides& overrides) {
  Study study;
  study.file = file;
  study.base_folder = base_folder;
  ReadYaml(
      text, file,
      [&](Archive& archive) {
        SerializeStudy(archive, study);
        CheckConsistency(study, archive);
      },
      overrides);
  for (std::string& warning : PrepareBackend(study)) study.warnings.push_back(std::move(warning));
  WarnOfCrowding(study);
  return study;
}

Study Study::Load(const std::string& path, const Overrides& overrides) {
  std::filesystem::path file = path;
  if (!std::filesystem::exists(file)) {
    const std::vector<std::string> names = ShippedStudies();
    const std::string name = file.replace_extension().generic_string();
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      throw InputError(fmt::format("no such study file; shipped studies: {}", JoinNames(names)),
                       {.location = {path}, .suggestion = NearestStudy(name, names)});
    }
    file = LibraryFolder() / (name + ".yaml");
  }
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  return Parse(ReadFile(file), file.string(), folder, overrides);
}

std::vector<std::string> ShippedStudies() {
  namespace fs = std::filesystem;
  std::vector<std::string> names;
  std::error_code error;
  const fs::path library = LibraryFolder();
  for (fs::recursive_directory_iterator entry(library, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() != ".yaml") continue;
    names.push_back(entry->path().lexically_relative(library).replace_extension().generic_string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string Study::ToYaml() {
  return WriteYaml([this](Archive& archive) { SerializeStudy(archive, *this); });
}

std::string Study::Fingerprint() {
  return Sha256(WriteYaml([this](Archive& archive) { SerializeProblem(archive, *this, true); }) +
                backend.backend->Fingerprint());
}

std::vector<std::size_t> Study::CalibratedExperiments() const {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    if (experiments[i].calibrate) indices.push_back(i);
  }
  return indices;
}

std::vector<std::size_t> Study::TransferExperiments(const std::vector<std::string>& names) const {
  std::vector<std::string> listed;
  std::vector<std::string> others;
  for (const StudyExperiment& entry : experiments) {
    listed.push_back(entry.name());
    if (!entry.calibrate) others.push_back(entry.name());
  }
  const InputError::Details details{.location = {"command line"}, .key = "--evaluate-also"};
  const std::string choice =
      others.empty() ? "the study has no experiment that is not calibrated; list one without "
                       "'observed', or with 'calibrate: false'"
                     : fmt::format("not calibrated: {}", JoinNames(others));
  for (const std::string& wanted : names) {
    if (std::find(others.begin(), others.end(), wanted) != others.end()) continue;
    if (std::find(listed.begin(), listed.end(), wanted) != listed.end()) {
      throw InputError(fmt::format("'{}' is calibrated in this study; {}", wanted, choice),
                       details);
    }
    InputError::Details unknown = details;
    unknown.suggestion = NearestName(wanted, listed);
    throw InputError(fmt::format("experiment '{}' is not in the study ({}); {}", wanted,
                                 JoinNames(listed), choice),
                     unknown);
  }
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    if (std::find(names.begin(), names.end(), experiments[i].name()) != names.end()) {
      indices.push_back(i);
    }
  }
  return indices;
}

Fidelity Study::FidelityOf(std::size_t experiment) const {
  return experiments[experiment].fidelity.value_or(backend.fidelity);
}

Objectives Study::MakeObjectives() const {
  Objectives objectives{.kind = objective};
  int index = 0;
  for (const std::size_t i : CalibratedExperiments()) {
    const StudyExperiment& entry = experiments[i];
    for (const ObservedResponse& observed : entry.observed) {
      objectives.targets.push_back({.response = entry.name() + "." + observed.response,
                                    .unit = UnitOf(entry, observed),
                                    .value = observed.value,
                                    .sd = observed.sd,
                                    .objective = index});
    }
    ++index;
  }
  return objectives;
}

std::vector<const ObservedResponse*> Study::Observations() const {
  std::vector<const ObservedResponse*> list;
  for (const std::size_t i : CalibratedExperiments()) {
    for (const ObservedResponse& observed : experiments[i].observed) list.push_back(&observed);
  }
  return list;
}

ContactLaw Study::LawAt(const std::vector<double>& parameters) const {
  SimulatedPowder simulated{.sizes = powder.sizes, .materials = {}, .law = law};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = space.parameters[i];
    if (parameter.categorical()) ApplyParameter(parameter, parameters[i], simulated);
  }
  return simulated.law;
}

int Study::parallel() const {
  if (budget.parallel > 0) return budget.parallel;
  return std::max(1, Cores() / backend.backend->cores());
}

std::filesystem::path LibraryFolder() {
  if (const char* folder = std::getenv("POWDERCAL_STUDIES")) return folder;
  // An installed program looks beside itself first, wherever it was installed to.
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path beside =
      program.parent_path().parent_path() / "share" / "powdercal" / "studies";
  if (!error && std::filesystem::is_directory(beside, error)) return beside;
  for (const char* folder : {POWDERCAL_SOURCE_STUDIES, POWDERCAL_INSTALLED_STUDIES}) {
    if (std::filesystem::is_directory(folder, error)) return folder;
  }
  return {};
}

}  // namespace powdercal
