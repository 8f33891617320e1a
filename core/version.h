#pragma once

namespace powdercal {

/// Version of powdercal, "0.1.0".
extern const char* const kVersion;

}  // namespace powdercal
