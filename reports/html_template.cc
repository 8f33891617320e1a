#include "reports/html_template.h"

namespace powdercal {

std::string FillTemplate(std::string_view text,
                         const std::map<std::string, std::string, std::less<>>& values) {
  std::string filled;
  while (true) {
    const std::size_t open = text.find("{{");
    const std::size_t close = text.find("}}", open == std::string_view::npos ? 0 : open);
    if (open == std::string_view::npos || close == std::string_view::npos) break;
    filled += text.substr(0, open);
    const auto value = values.find(text.substr(open + 2, close - open - 2));
    if (value != values.end()) filled += value->second;
    text.remove_prefix(close + 2);
  }
  return filled.append(text);
}

}  // namespace powdercal
