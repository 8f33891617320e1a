#pragma once

#include <span>
#include <string_view>

namespace powdercal::yade {

/// A Python file of the driver, compiled into the library.
struct DriverFile {
  std::string_view name;  ///< "main.py"
  std::string_view text;
};

/// All files of backends/yade/driver/; main.py is what is to be run.
std::span<const DriverFile> Driver();

}  // namespace powdercal::yade
