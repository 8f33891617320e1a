#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace powdercal {

/// The whole file. Throws InputError when it cannot be read.
std::string ReadFile(const std::filesystem::path& path);

/// Replaces the file so that a reader, or a crash at any moment, sees either the old content or the
/// new one, never a part. Throws InputError when it cannot be written.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

}  // namespace powdercal
