#include "core/text.h"

#include <algorithm>
#include <boost/locale/utf.hpp>

namespace powdercal {

std::string ValidUtf8(std::string_view bytes) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  std::string valid;
  valid.reserve(bytes.size());
  for (const char* position = bytes.begin(); position != bytes.end();) {
    const char* const start = position;
    const auto character = Utf8::decode(position, bytes.end());
    if (boost::locale::utf::is_valid_codepoint(character)) {
      valid.append(start, position);
    } else {
      valid += "\xEF\xBF\xBD";
      position = start + 1;  // decode() swallows the byte after a broken sequence
    }
  }
  return valid;
}

std::string_view Trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

int CountCharacters(std::string_view utf8) {
  return static_cast<int>(std::count_if(utf8.begin(), utf8.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;  // not a continuation byte
  }));
}

}  // namespace powdercal
