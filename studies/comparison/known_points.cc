#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "studies/comparison/emulator.h"

namespace powdercal::comparison {
namespace {

// Top-level section → its lines.
std::map<std::string, std::string> Sections(const std::string& yaml) {
  std::map<std::string, std::string> sections;
  std::string current;
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(' ')) current = line.substr(0, line.find(':'));
    sections[current] += line + "\n";
  }
  return sections;
}

// The study without what has no influence on what a simulation at a point gives.
std::map<std::string, std::string> ProblemOf(Study& study) {
  Study copy = Study::Parse(study.ToYaml(), study.file, study.base_folder);
  copy.backend.replicates = copy.backend.confirm_replicates = 1;
  copy.backend.confirm_with.clear();
  std::erase_if(copy.experiments, [](const StudyExperiment& e) { return !e.calibrate; });
  for (std::size_t i = 0; i < copy.experiments.size(); ++i) {
    // Written out, so that it does not matter whether it came from the study or the experiment.
    copy.experiments[i].fidelity = copy.FidelityOf(i);
    for (ObservedResponse& observed : copy.experiments[i].observed) {
      observed.value = 0;  // the target is the study's own; which responses there are is not
      observed.sd = 1;
      observed.tolerance.reset();
      observed.source.clear();
    }
  }
  copy.backend.fidelity = Fidelity::quick;
  std::map<std::string, std::string> sections = Sections(copy.ToYaml());
  for (const char* key : {"study", "description", "seed", "objective", "optimizer", "budget"}) {
    sections.erase(key);
  }
  return sections;
}

bool Holds(const std::vector<LedgerRun>& runs, const LedgerRun& run) {
  return std::any_of(runs.begin(), runs.end(),
                     [&](const LedgerRun& known) { return known.key == run.key; });
}

}  // namespace

std::vector<KnownPoint> ReadKnownPoints(const Study& study, const Ledger& ledger) {
  const std::vector<std::size_t> calibrated = study.CalibratedExperiments();
  const auto wanted = [&](const LedgerRun& run) {
    return run.backend == study.backend.backend->name() &&
           std::any_of(calibrated.begin(), calibrated.end(), [&](std::size_t i) {
             return study.experiments[i].name() == run.experiment;
           });
  };
  std::map<std::int64_t, LedgerRun> runs;
  for (LedgerRun& run : ledger.Runs()) runs.emplace(run.id, std::move(run));
  std::vector<KnownPoint> points;
  for (const LedgerCandidate& entry : ledger.Candidates()) {
    const Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(
        entry.parameters.data(), static_cast<Eigen::Index>(entry.parameters.size()));
    if (values.size() != study.space.dimension()) continue;
    KnownPoint point{.point = study.space.ToUnit(values), .runs = {}};
    for (std::size_t i = 0; i < entry.runs.size(); ++i) {
      const LedgerRun& run = runs.at(entry.runs[i]);
      if (entry.replicates[i] >= 0 && wanted(run)) point.runs.push_back(run);
    }
    if (!point.runs.empty()) Merge({std::move(point)}, &points);
  }
  return points;
}

void Merge(const std::vector<KnownPoint>& more, std::vector<KnownPoint>* points) {
  for (const KnownPoint& point : more) {
    auto same = std::find_if(points->begin(), points->end(),
                             [&](const KnownPoint& p) { return p.point == point.point; });
    if (same == points->end()) {
      points->push_back({point.point, {}});
      same = points->end() - 1;
    }
    for (const LedgerRun& run : point.runs) {
      if (!Holds(same->runs, run)) same->runs.push_back(run);
    }
  }
}

std::string ExplainOtherProblem(Study& study, Study& other) {
  const auto mine = ProblemOf(study);
  const auto theirs = ProblemOf(other);
  std::vector<std::string> differing;
  for (const auto& [section, text] : mine) {
    const auto found = theirs.find(section);
    if (found == theirs.end() || found->second != text) differing.push_back(section);
  }
  for (const auto& [section, text] : theirs) {
    if (!mine.contains(section)) differing.push_back(section);
  }
  if (differing.empty()) return "";
  return fmt::format("its simulations are of another problem than study '{}': {} differ{}",
                     study.name, JoinNames(differing), differing.size() == 1 ? "s" : "");
}

}  // namespace powdercal::comparison
