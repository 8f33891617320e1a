#pragma once

#include <string>
#include <string_view>

namespace powdercal {

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string Sha256(std::string_view bytes);

}  // namespace powdercal
