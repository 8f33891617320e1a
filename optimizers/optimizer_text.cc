#include "optimizers/optimizer_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/archive.h"
#include "core/errors.h"

namespace powdercal {
namespace {

constexpr const char* kDesignKey = "initial_design";

// "a=1,b=2" → "a=1", "b=2"
std::vector<std::string> SplitOptions(const std::string& text) {
  std::vector<std::string> items(1);
  for (const char c : text) {
    if (c == ',') {
      items.emplace_back();
    } else {
      items.back() += c;
    }
  }
  return items;
}

}  // namespace

bool HasInitialDesign(const OptimizerFactory& factory, const SearchSpace& space) {
  const std::unique_ptr<OptimizerFactory> fresh = MakeOptimizerFactory(factory.name());
  try {
    ReadYaml(fmt::format("{}: sobol", kDesignKey), factory.name(),
             [&](Archive& archive) { fresh->Serialize(archive, space); });
  } catch (const InputError&) {
    return false;  // an unknown key
  }
  return true;
}

std::unique_ptr<OptimizerFactory> ParseOptimizer(const std::string& text, const SearchSpace& space,
                                                 const DesignOptions* initial_design) {
  const std::size_t colon = text.find(':');
  std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory(text.substr(0, colon));
  Overrides overrides;
  if (colon != std::string::npos) AddOverrides(SplitOptions(text.substr(colon + 1)), &overrides);
  const bool named = std::any_of(overrides.begin(), overrides.end(), [](const auto& item) {
    return item.first.starts_with(kDesignKey);
  });
  std::string section = "{}";
  if (initial_design != nullptr && !named && HasInitialDesign(*factory, space)) {
    DesignOptions design = *initial_design;
    section =
        WriteYaml([&](Archive& archive) { design.SerializeSection(archive, kDesignKey, space); });
  }
  ReadYaml(
      section, text, [&](Archive& archive) { factory->Serialize(archive, space); }, overrides);
  return factory;
}

}  // namespace powdercal
