#include "studies/study_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "core/errors.h"

namespace powdercal {
namespace {

// With an experiment that takes files, `yield_locus: shear.csv` is short for `yield_locus: {file:
// shear.csv}`.
constexpr const char* kFileKey = "file";

const ResponseDescription* FindResponse(const Experiment& experiment, const std::string& name) {
  for (const ResponseDescription& response : experiment.responses()) {
    if (response.name == name) return &response;
  }
  return nullptr;
}

void RejectSecondObservation(const StudyExperiment& entry, const std::string& response,
                             const Archive& section) {
  const auto same = [&](const ObservedResponse& o) { return o.response == response; };
  if (std::none_of(entry.observed.begin(), entry.observed.end(), same)) return;
  throw section.ErrorAt("", fmt::format("'{}' is observed twice, once in a file", response));
}

void ReadDataFile(const std::string& key, const std::filesystem::path& base_folder,
                  Archive& section, StudyExperiment& entry) {
  section.Require(kFileKey);
  std::string file;
  section.Text(kFileKey, file);
  std::string source = file;
  section.Text("source", source);
  const std::string path = (base_folder / file).string();
  std::vector<ObservedValue> values;
  try {
    values = entry.experiment->ReadObserved(key, path);
  } catch (const InputError& error) {
    if (error.details().location.line > 0) throw;  // a place in the file itself
    throw section.ErrorAt(kFileKey, fmt::format("{}: {}", path, error.problem()));
  }
  if (values.empty()) {
    throw section.ErrorAt(kFileKey, fmt::format("{}: there is no observation in it", path));
  }
  for (const ObservedValue& value : values) {
    assert(FindResponse(*entry.experiment, value.response) != nullptr && value.sd > 0);
    RejectSecondObservation(entry, value.response, section);
    entry.observed.push_back(
        {.response = value.response, .value = value.value, .sd = value.sd, .source = source});
  }
}

void SerializeResponse(const ResponseDescription& known, Archive& section,
                       ObservedResponse& observed) {
  observed.response = known.name;
  section.Require("value");
  section.Quantity("value", observed.value, known.unit);
  section.Require("sd");
  section.Quantity("sd", observed.sd, known.unit, kPositive);
  section.Quantity("tolerance", observed.tolerance, known.unit, kPositive);
  section.Text("source", observed.source);
}

void SerializeObserved(Archive& archive, const std::filesystem::path& base_folder,
                       StudyExperiment& entry) {
  const Experiment& experiment = *entry.experiment;
  const auto files = experiment.observed_files();
  std::vector<std::string> keys;
  for (const ObservedResponse& observed : entry.observed) keys.push_back(observed.response);
  std::size_t index = 0;
  const auto visit = [&](const std::string& name, Archive& section) {
    if (section.reading() && std::find(files.begin(), files.end(), name) != files.end()) {
      ReadDataFile(name, base_folder, section, entry);
      return;
    }
    const ResponseDescription* known = FindResponse(experiment, name);
    if (known == nullptr) {
      std::vector<std::string> names(files.begin(), files.end());
      for (const ResponseDescription& response : experiment.responses()) {
        names.push_back(response.name);
      }
      std::sort(names.begin(), names.end());
      throw UnknownName(experiment.name() + " response", name, names,
                        {.location = section.LocationOf("")});
    }
    if (section.reading()) {
      if (!files.empty() && section.Has(kFileKey)) {
        throw section.ErrorAt(kFileKey,
                              fmt::format("'{}' is not read from a file; give its value and sd "
                                          "(read from files: {})",
                                          name, JoinNames(files)));
      }
      RejectSecondObservation(entry, name, section);
      SerializeResponse(*known, section, entry.observed.emplace_back());
    } else {
      SerializeResponse(*known, section, entry.observed[index++]);
    }
  };
  archive.Map("observed", keys, visit, files.empty() ? "" : kFileKey);
}

StudyExperiment& AddExperiment(const std::string& name, const Archive& item,
                               std::vector<StudyExperiment>& experiments) {
  StudyExperiment entry;
  try {
    entry.experiment = MakeExperiment(name);
  } catch (const InputError&) {
    throw UnknownName("experiment", name, ExperimentNames(),
                      {.location = item.LocationOf(name), .key = "experiments"});
  }
  for (const StudyExperiment& other : experiments) {
    if (other.name() == name) {
      throw item.ErrorAt(name, fmt::format("experiment '{}' is listed twice", name));
    }
  }
  return experiments.emplace_back(std::move(entry));
}

}  // namespace

void StudyExperiment::Serialize(Archive& section, const std::filesystem::path& base_folder) {
  experiment->Serialize(section);
  Fidelity own = fidelity.value_or(Fidelity::quick);
  if (section.reading() || fidelity) {
    const bool given = section.Has("fidelity");
    section.Enumeration("fidelity", own, "fidelity", FidelityNames());
    if (given) fidelity = own;
  }
  SerializeObserved(section, base_folder, *this);
  if (section.reading()) calibrate = !observed.empty();
  section.Flag("calibrate", calibrate);
  if (calibrate && observed.empty()) {
    throw section.ErrorAt("calibrate",
                          "there is nothing to calibrate against: give what was 'observed'");
  }
}

void SerializeExperiments(Archive& archive, std::vector<StudyExperiment>& experiments,
                          const std::filesystem::path& base_folder, bool calibrated_only) {
  archive.Require("experiments");
  std::vector<StudyExperiment*> written;
  if (!archive.reading()) {
    for (StudyExperiment& entry : experiments) {
      if (entry.calibrate || !calibrated_only) written.push_back(&entry);
    }
  }
  std::size_t index = 0;
  archive.List("experiments", written.size(), [&](Archive& item) {
    StudyExperiment* entry = item.reading() ? nullptr : written[index++];
    std::string name = entry == nullptr ? "" : entry->name();
    item.Tagged(name, [&](const std::string& tag, Archive& section) {
      if (section.reading()) entry = &AddExperiment(tag, item, experiments);
      entry->Serialize(section, base_folder);
    });
  });
  if (experiments.empty()) {
    throw archive.ErrorAt("experiments", "a study needs at least one experiment");
  }
}

}  // namespace powdercal
