#include "optimizers/optimizer_text.h"

#include <algorithm>
#include <vector>

#include "core/archive.h"

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

std::unique_ptr<OptimizerFactory> ParseOptimizer(const std::string& text, const SearchSpace& space,
                                                 const DesignOptions* initial_design) {
  const std::size_t colon = text.find(':');
  std::unique_ptr<OptimizerFactory> factory = MakeOptimizerFactory(text.substr(0, colon));
  Overrides overrides;
  if (colon != std::string::npos) AddOverrides(SplitOptions(text.substr(colon + 1)), &overrides);
  const bool named = std::any_of(overrides.begin(), overrides.end(), [](const auto& item) {
    return item.first.starts_with(kDesignKey);
  });
  ReadYaml("{}", text, [&](Archive& archive) { factory->Serialize(archive, space); }, overrides);
  DesignOptions* own = factory->initial_design();
  if (initial_design != nullptr && own != nullptr && !named) *own = *initial_design;
  return factory;
}

}  // namespace powdercal
