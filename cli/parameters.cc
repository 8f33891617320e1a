#include "cli/parameters.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "core/errors.h"
#include "core/quantity.h"

namespace powdercal::cli {
namespace {

double ReadParameter(const Parameter& parameter, const std::string& text) {
  const InputError::Details details{
      .location = {"command line"}, .key = parameter.name, .value = text};
  if (parameter.categorical()) {
    const auto found = std::find(parameter.categories.begin(), parameter.categories.end(), text);
    if (found == parameter.categories.end()) {
      throw UnknownName("choice", text, parameter.categories, details);
    }
    return static_cast<double>(found - parameter.categories.begin());
  }
  double value = 0;
  try {
    const powdercal::Quantity quantity = powdercal::Quantity::Parse(text);
    value = quantity.dimension.dimensionless() ? quantity.si : ParseQuantity(text, parameter.unit);
  } catch (const InputError& error) {
    throw InputError(error.problem(), details);
  }
  if (value < 0) throw InputError("must be at least 0", details);
  return value;
}

}  // namespace

std::vector<double> ReadParameters(const Study& study, const std::vector<std::string>& texts,
                                   const std::vector<double>& defaults) {
  const auto& known = study.space.parameters;
  std::vector<std::optional<double>> values(known.size());
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw InputError("expected -p NAME=VALUE", {.location = {"command line"}, .value = text});
    }
    const std::string name = text.substr(0, equals);
    const auto found = std::find_if(known.begin(), known.end(), [&](const Parameter& p) {
      return p.name == name || p.symbol == name;
    });
    if (found == known.end()) {
      std::vector<std::string> names;
      for (const Parameter& p : known) names.push_back(p.name);
      throw UnknownName("parameter", name, names, {.location = {"command line"}});
    }
    std::optional<double>& value = values[static_cast<std::size_t>(found - known.begin())];
    if (value) throw InputError("given twice", {.location = {"command line"}, .key = found->name});
    value = ReadParameter(*found, text.substr(equals + 1));
  }
  std::vector<double> result;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (!values[i] && i < defaults.size()) values[i] = defaults[i];
    if (!values[i]) {
      throw InputError(fmt::format("missing parameter '{}'; give it as -p {}=VALUE", known[i].name,
                                   known[i].symbol),
                       {.location = {"command line"}});
    }
    result.push_back(*values[i]);
  }
  return result;
}

std::vector<std::size_t> ReadExperiments(const Study& study,
                                         const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const StudyExperiment& entry : study.experiments) known.push_back(entry.name());
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw UnknownName("experiment", name, known,
                      {.location = {"command line"}, .key = "--experiment"});
  }
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (names.empty() || std::find(names.begin(), names.end(), known[i]) != names.end()) {
      indices.push_back(i);
    }
  }
  return indices;
}

std::filesystem::path MakeTemporaryFolder() {
  std::string name = std::filesystem::temp_directory_path() / "powdercal-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) {
    throw InputError(fmt::format("cannot make a temporary folder: {}", std::strerror(errno)),
                     {.location = {name}});
  }
  return name;
}

}  // namespace powdercal::cli
