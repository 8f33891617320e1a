#include <fmt/format.h>

#include <algorithm>

#include "cli/commands.h"

namespace powdercal::cli {
namespace {

struct Shorthand {
  const char* option;
  const char* key;
  const char* help;
};
constexpr Shorthand kShorthands[] = {
    {"--seed", "seed", "seed of the optimizer and the particles"},
    {"--backend", "backend.name", "simulator (see `powdercal list backends`)"},
    {"--fidelity", "backend.fidelity", "size of the simulations: quick, standard or paper"},
    {"--optimizer", "optimizer",
     "another optimizer with its defaults (see `powdercal list optimizers`)"},
    {"--evaluations", "budget.evaluations", "number of parameter points"},
    {"--parallel", "budget.parallel", "simulations at a time; 0: as many as keep all cores busy"},
    {"--wall-time", "budget.wall_time", "limit of the whole study, e.g. '2 h'"},
    {"--run-timeout", "budget.run_timeout", "limit of one simulation, e.g. '10 min'"},
};

}  // namespace

std::string NotEmpty(const std::string& value) { return value.empty() ? "a value is missing" : ""; }

void StudyOptions::Declare(CLI::App& command, bool required) {
  command.add_option("study", file_, "study file, or name of a shipped study")
      ->required(required)
      ->type_name("STUDY");
  for (const Shorthand& shorthand : kShorthands) {
    command.add_option(shorthand.option, shorthands_[shorthand.key], shorthand.help)
        ->type_name("VALUE")
        ->check(NotEmpty);
  }
  command.add_flag("--deterministic", deterministic_,
                   "tell results in asking order, whatever finishes first");
  command.add_option("--set", sets_, "any other key, e.g. --set 'optimizer.acquisition=ei'")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

std::string StudyOptions::Given(const std::string& shorthand) const {
  for (const Shorthand& known : kShorthands) {
    if (shorthand == known.option) return shorthands_.at(known.key);
  }
  return "";
}

std::vector<std::string> StudyOptions::GivenOptions(const std::vector<std::string>& except) const {
  std::vector<std::string> given;
  for (const Shorthand& known : kShorthands) {
    if (!shorthands_.at(known.key).empty()) given.emplace_back(known.option);
  }
  if (deterministic_) given.emplace_back("--deterministic");
  if (!sets_.empty()) given.emplace_back("--set");
  std::erase_if(given, [&](const std::string& option) {
    return std::find(except.begin(), except.end(), option) != except.end();
  });
  return given;
}

std::vector<std::string> StudyOptions::Words() const {
  std::vector<std::string> words = {file_};
  for (const Shorthand& known : kShorthands) {
    const std::string& value = shorthands_.at(known.key);
    if (!value.empty()) words.insert(words.end(), {known.option, value});
  }
  if (deterministic_) words.emplace_back("--deterministic");
  for (const std::string& set : sets_) words.insert(words.end(), {"--set", set});
  return words;
}

Overrides StudyOptions::Collect() const {
  Overrides overrides;
  for (const auto& [key, value] : shorthands_) {
    if (!value.empty()) overrides[key] = value;
  }
  if (deterministic_) overrides["budget.deterministic"] = "true";
  AddOverrides(sets_, &overrides);
  return overrides;
}

Study StudyOptions::Load() const { return Study::Load(file_, Collect()); }

std::filesystem::path StudyOptions::DefaultFolder(const Study& study) const {
  if (study.name.empty() || study.name.starts_with('.') ||
      study.name.find('/') != std::string::npos) {
    throw InputError("the study's name cannot be that of its run folder; choose one with --out",
                     {.location = {study.file}, .key = "study", .value = study.name});
  }
  const Overrides overrides = Collect();
  const auto seed = overrides.find("seed");
  return std::filesystem::path("runs") /
         (seed == overrides.end() ? study.name : study.name + "-seed" + seed->second);
}

}  // namespace powdercal::cli
