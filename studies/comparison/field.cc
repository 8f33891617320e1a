#include "studies/comparison/field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "optimizers/designs/orthogonal_array.h"
#include "optimizers/optimizer_text.h"

namespace powdercal::comparison {
namespace {

constexpr const char* kDesignKey = "initial_design";

InputError::Details CommandLine(const std::string& value = "") {
  return {.location = {"command line"}, .key = "--optimizers", .value = value};
}

bool IsDesign(const std::string& name) {
  const auto names = DesignNames();
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string NameOf(const std::string& label) { return label.substr(0, label.find(':')); }

std::string OptionsOf(OptimizerFactory& factory, const SearchSpace& space) {
  return WriteYaml([&](Archive& archive) { factory.Serialize(archive, space); });
}

// Resolved, without the initial design.
std::string OptionsWithoutDesign(OptimizerFactory& factory, const SearchSpace& space) {
  std::istringstream lines(OptionsOf(factory, space));
  std::string rest;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(' ')) inside = line.starts_with(std::string(kDesignKey) + ":");
    if (!inside) rest += line + "\n";
  }
  return rest;
}

// A design in full has the budget's number of points, unless the label says how many.
std::string WithBudget(const std::string& label, int evaluations, int dimension) {
  const std::string name = NameOf(label);
  const auto add = [&](const char* key, int value) {
    if (label.find(fmt::format("{}=", key)) != std::string::npos) return label;
    return fmt::format("{}{}{}={}", label, label == name ? ":" : ",", key, value);
  };
  if (name == "sobol" || name == "latin_hypercube") return add("points", evaluations);
  if (name == "orthogonal_array") {
    int levels = OrthogonalArrayLevels().front();
    for (const int more : OrthogonalArrayLevels()) {
      if (more * more <= evaluations) levels = more;
    }
    return add("levels", levels);
  }
  if (name != "grid") return label;
  int levels = 2;
  while (std::pow(levels + 1, dimension) <= evaluations) ++levels;
  return add("levels", levels);
}

DesignOptions AsList(const DesignOptions& design, const SearchSpace& space, std::uint64_t seed) {
  DesignOptions list{.name = "list"};
  for (const DesignPoint& point : MakeDesign(design, space, seed)) {
    const Eigen::VectorXd values = space.FromUnit(point.point);
    list.list.emplace_back(values.begin(), values.end());
  }
  return list;
}

}  // namespace

std::vector<std::string> SplitLabels(const std::string& text) {
  std::vector<std::string> labels;
  std::string piece;
  int depth = 0;
  const auto end_piece = [&] {
    const std::size_t equals = piece.find('=');
    const bool continued = !labels.empty() && equals != std::string::npos &&
                           piece.find(':') > equals && labels.back().find(':') != std::string::npos;
    if (continued) {
      labels.back() += "," + piece;
    } else {
      labels.push_back(piece);
    }
    piece.clear();
  };
  for (const char c : text) {
    if (c == '{' || c == '[') ++depth;
    if (c == '}' || c == ']') --depth;
    if (c == ',' && depth == 0) {
      end_piece();
    } else {
      piece += c;
    }
  }
  end_piece();
  return labels;
}

Field::Field(Study& study, const std::vector<std::string>& labels, int evaluations)
    : study_(study),
      objectives_(study.MakeObjectives()),
      evaluations_(evaluations),
      initial_design_{.name = "sobol"} {
  if (const DesignOptions* own = study.optimizer->initial_design()) initial_design_ = *own;
  if (const std::string reason = initial_design_.ExplainUnsupported(study.space); !reason.empty()) {
    throw InputError(reason, {.location = {study.file}, .key = kDesignKey});
  }
  for (auto label = labels.begin(); label != labels.end(); ++label) {
    if (std::find(labels.begin(), label, *label) != label) {
      throw InputError("given twice", CommandLine(*label));
    }
    Add(*label, true);
  }
  if (labels.empty()) {
    for (const std::string& name : OptimizerNames()) Add(name, false);
  }
  if (!contestants_.empty()) return;
  std::string reasons;
  for (const Refusal& refusal : refused_) {
    reasons += fmt::format("; {}: {}", refusal.label, refusal.reason);
  }
  throw InputError("no optimizer is left that can treat this study" + reasons, CommandLine());
}

void Field::Add(const std::string& label, bool asked_for) {
  Contestant contestant{.label = label, .name = NameOf(label), .description = {}, .options = {}};
  const auto names = OptimizerNames();
  if (std::find(names.begin(), names.end(), contestant.name) == names.end()) {
    throw UnknownName("optimizer", contestant.name, names, CommandLine());
  }
  contestant.study_options =
      label == contestant.name && contestant.name == study_.optimizer->name();
  contestant.design = IsDesign(contestant.name);
  std::unique_ptr<OptimizerFactory> factory;
  try {
    factory = MakeFactory(contestant, initial_design_);
  } catch (const InputError& error) {
    if (asked_for) throw;
    refused_.push_back({label, error.problem()});
    return;
  }
  contestant.description = factory->Describe();
  contestant.options = OptionsWithoutDesign(*factory, study_.space);
  contestant.initial_design =
      factory->initial_design() != nullptr && label.find(kDesignKey) == std::string::npos;
  const std::string reason = factory->Make(study_.space, objectives_, SeedOf(1))
                                 ->ExplainUnsupported(study_.space, objectives_);
  if (reason.empty()) {
    contestants_.push_back(std::move(contestant));
  } else {
    refused_.push_back({label, reason});
  }
}

std::unique_ptr<OptimizerFactory> Field::MakeFactory(const Contestant& contestant,
                                                     const DesignOptions& design) const {
  const int dimension = study_.space.dimension();
  if (!contestant.study_options) {
    return ParseOptimizer(WithBudget(contestant.label, evaluations_, dimension), study_.space,
                          &design);
  }
  auto factory = MakeOptimizerFactory(contestant.name);
  ReadYaml(OptionsOf(*study_.optimizer, study_.space), study_.file,
           [&](Archive& archive) { factory->Serialize(archive, study_.space); });
  if (DesignOptions* own = factory->initial_design()) *own = design;
  return factory;
}

std::uint64_t Field::SeedOf(int seed) const {
  return study_.seed + static_cast<std::uint64_t>(seed) - 1;
}

std::unique_ptr<Optimizer> Field::Make(const Contestant& contestant, int seed) const {
  return MakeFactory(contestant, AsList(initial_design_, study_.space, SeedOf(seed)))
      ->Make(study_.space, objectives_, SeedOf(seed));
}

}  // namespace powdercal::comparison
