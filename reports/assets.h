#pragma once

#include <string_view>

namespace powdercal {

/// Files compiled into the program: those of reports/assets/ and the plotting libraries of
/// package.json (reports/CMakeLists.txt has the list). Named as the file; an unknown name is a
/// programmer's error.
std::string_view Asset(std::string_view name);

}  // namespace powdercal
