#pragma once

#include <memory>
#include <string>

#include "core/errors.h"
#include "scaling/scaling.h"

namespace powdercal {

/// The mode that a study's text names.
inline std::unique_ptr<Scaling> Read(const std::string& yaml) {
  std::unique_ptr<Scaling> scaling;
  ReadYaml(yaml, "study.yaml", [&](Archive& archive) { SerializeScaling(archive, scaling); });
  return scaling;
}

/// What is wrong with the text, or "no error".
inline std::string ErrorOf(const std::string& yaml) {
  try {
    Read(yaml);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace powdercal
