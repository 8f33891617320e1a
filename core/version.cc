#include "core/version.h"

namespace powdercal {

const char* const kVersion = POWDERCAL_VERSION;

}  // namespace powdercal
