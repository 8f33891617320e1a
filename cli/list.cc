#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "backends/registry.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "cli/text.h"
#include "experiments/experiment.h"
#include "optimizers/optimizer.h"
#include "scaling/scaling.h"
#include "surrogates/surrogate.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

json ListBackends() {
  json list = json::array();
  for (const std::string& name : BackendNames()) {
    const auto backend = MakeBackend(name);
    const Availability availability = backend->availability();
    list.push_back({{"name", name},
                    {"available", availability.available},
                    {"version", availability.version},
                    {"why_not", availability.why_not},
                    {"description", backend->Describe()},
                    {"simulates", backend->simulates()}});
  }
  return list;
}

json ListExperiments() {
  json list = json::array();
  for (const std::string& name : ExperimentNames()) {
    json responses = json::array();
    const auto experiment = MakeExperiment(name);
    for (const ResponseDescription& response : experiment->responses()) {
      responses.push_back({{"name", response.name},
                           {"unit", response.unit},
                           {"description", response.description}});
    }
    list.push_back({{"name", name}, {"responses", responses}});
  }
  return list;
}

json ListOptimizers() {
  json list = json::array();
  for (const std::string& name : OptimizerNames()) {
    list.push_back({{"name", name}, {"description", MakeOptimizerFactory(name)->Describe()}});
  }
  return list;
}

json ListParameters() {
  json list = json::array();
  for (const FreeParameter& parameter : FreeParameters()) {
    list.push_back({{"name", parameter.name},
                    {"unit", parameter.unit},
                    {"symbol", parameter.symbol},
                    {"description", parameter.description}});
    if (parameter.categories.empty()) continue;
    list.back()["choices"] = parameter.categories;
    list.back()["description"] =
        fmt::format("{}: {}", parameter.description, JoinNames(parameter.categories));
  }
  return list;
}

json ListNames(std::span<const std::string> names) {
  json list = json::array();
  for (const std::string& name : names) list.push_back({{"name", name}});
  return list;
}

json ListStudies() {
  json list = json::array();
  for (const std::string& name : ShippedStudies()) {
    list.push_back({{"name", name}, {"file", (LibraryFolder() / (name + ".yaml")).string()}});
  }
  return list;
}

std::string Text(const json& item, const char* key) { return item.value(key, std::string()); }

void PrintKind(const std::string& kind, const json& list) {
  std::vector<std::vector<std::string>> rows;
  for (const json& item : list) {
    if (kind == "backends") {
      const bool available = item.at("available");
      rows.push_back({item.at("name"), available ? Text(item, "version") : "absent",
                      available ? (item.at("simulates") ? Text(item, "description")
                                                        : "no simulation: a surrogate of a table")
                                : Text(item, "why_not")});
    } else if (kind == "experiments") {
      for (const json& response : item.at("responses")) {
        rows.push_back({Text(item, "name") + "." + Text(response, "name"), Text(response, "unit"),
                        Text(response, "description")});
      }
    } else {
      rows.push_back(
          {item.at("name"), Text(item, "unit"), Text(item, "description") + Text(item, "file")});
    }
  }
  Print("{}\n{}", kind, AlignedTable(rows));
}

}  // namespace

void AddList(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("list", "What this installation offers.");
  struct Options {
    std::string kind;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  static const std::vector<std::string> kKinds = {
      "backends", "experiments", "optimizers", "parameters", "scaling", "studies", "surrogates"};
  command->add_option("kind", options->kind, "one of: " + JoinNames(kKinds) + " (default: all)")
      ->type_name("KIND");
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] {
    if (!options->kind.empty() &&
        std::find(kKinds.begin(), kKinds.end(), options->kind) == kKinds.end()) {
      throw UnknownName("kind", options->kind, kKinds);
    }
    json all = {{"backends", ListBackends()},
                {"experiments", ListExperiments()},
                {"optimizers", ListOptimizers()},
                {"parameters", ListParameters()},
                {"scaling", ListNames(ScalingNames())},
                {"studies", ListStudies()},
                {"surrogates", ListNames(SurrogateNames())}};
    if (!options->kind.empty()) all = {{options->kind, all.at(options->kind)}};
    if (options->json) {
      Print("{}\n", all.dump(2));
    } else {
      for (const auto& [kind, list] : all.items()) PrintKind(kind, list);
    }
    status = kDone;
  });
}

}  // namespace powdercal::cli
