#pragma once

#include <string>
#include <string_view>

namespace powdercal {

/// The text with each byte that is not part of valid UTF-8 replaced by U+FFFD.
std::string ValidUtf8(std::string_view bytes);

/// Without blanks and tabulators at both ends.
std::string_view Trim(std::string_view text);

/// Number of characters (code points) in UTF-8 text, where columns count characters and not bytes.
int CountCharacters(std::string_view utf8);

}  // namespace powdercal
