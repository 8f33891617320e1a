#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/text.h"
#include "scaling/pi_engine.h"

namespace powdercal::cli {
namespace {

using nlohmann::json;

std::string List(const std::vector<std::string>& names) {
  return names.empty() ? "none" : JoinNames(names);
}

void PrintGroups(const VariablesFile& file, const PiBasis& basis) {
  Print("{} variables of {} base quantities ({}), rank {}: {} groups\n", basis.variables.size(),
        basis.dimensions.size(), List(basis.dimensions), basis.rank, basis.groups.size());
  Print("repeating: {}\n", List(basis.repeating));
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < basis.groups.size(); ++i) {
    const std::string name = basis.names[i].empty() ? fmt::format("Pi_{}", i + 1) : basis.names[i];
    rows.push_back({name, "=", ToString(basis.groups[i])});
  }
  Print("{}", AlignedTable(rows));
  if (!file.prefer.empty() && !basis.not_repeating.empty()) {
    Print("note: {} cannot repeat: the preferred variables before span the same dimensions\n",
          JoinNames(basis.not_repeating));
  }
  if (!basis.unused.empty()) {
    Print(
        "note: {} in no group: no product of the other variables has such a dimension. Either it "
        "has no influence, or a variable is missing\n",
        basis.unused.size() == 1 ? basis.unused[0] + " is" : JoinNames(basis.unused) + " are");
  }
  if (basis.rank_deficient()) {
    Print(
        "note: the base quantities {} occur in {} independent combinations only, hence {} more "
        "than the usual number of groups\n",
        JoinNames(basis.dimensions), basis.rank,
        static_cast<int>(basis.dimensions.size()) - basis.rank);
  }
}

json GroupsToJson(const PiBasis& basis) {
  return {{"schema", 1},
          {"variables", basis.variables},
          {"dimensions", basis.dimensions},
          {"rank", basis.rank},
          {"rank_deficient", basis.rank_deficient()},
          {"repeating", basis.repeating},
          {"not_repeating", basis.not_repeating},
          {"unused", basis.unused},
          {"names", basis.names},
          {"groups", basis.groups}};
}

void ScaleVariables(const std::string& path, bool as_json) {
  const VariablesFile file = ReadVariables(path);
  const PiBasis basis = FindGroups(file.variables, file.prefer, file.named);
  if (as_json) {
    Print("{}\n", GroupsToJson(basis).dump(2));
  } else {
    PrintGroups(file, basis);
  }
}

}  // namespace

void AddScale(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("scale", "Print the Pi groups of any set of variables.");
  struct Options {
    std::string variables;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  command
      ->add_option("--variables", options->variables,
                   "file of variables and their units: the groups of any problem")
      ->type_name("FILE")
      ->check(NotEmpty)
      ->required();
  command->add_flag("--json", options->json, "for machines");
  command->callback([options, &status] {
    ScaleVariables(options->variables, options->json);
    status = kDone;
  });
}

}  // namespace powdercal::cli
