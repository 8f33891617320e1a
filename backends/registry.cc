#include "backends/registry.h"

#include <vector>

#include "backends/embedded/embedded.h"
#include "backends/liggghts/liggghts.h"
#include "backends/table/table.h"
#include "backends/yade/yade.h"
#include "core/errors.h"

namespace powdercal {
namespace {

struct Entry {
  const char* name;
  std::unique_ptr<Backend> (*make)();
};

template <typename B>
std::unique_ptr<Backend> Make() {
  return std::make_unique<B>();
}

// Sorted by name. A new backend is one line here.
constexpr Entry kBackends[] = {
    {"embedded", MakeEmbeddedBackend},
    {"liggghts", MakeLiggghtsBackend},
    {"table", Make<TableBackend>},
    {"yade", MakeYadeBackend},
};

}  // namespace

std::span<const std::string> BackendNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Entry& entry : kBackends) list.emplace_back(entry.name);
    return list;
  }();
  return names;
}

std::unique_ptr<Backend> MakeBackend(const std::string& name) {
  for (const Entry& entry : kBackends) {
    if (name == entry.name) return entry.make();
  }
  throw UnknownName("backend", name, BackendNames());
}

}  // namespace powdercal
