#include "reports/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

#include "core/text.h"

namespace powdercal {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

const std::map<std::string_view, std::string_view>& GreekLetters() {
  static const std::map<std::string_view, std::string_view> kLetters = {
      {"alpha", "α"}, {"beta", "β"},  {"gamma", "γ"},  {"delta", "δ"}, {"epsilon", "ε"},
      {"eta", "η"},   {"kappa", "κ"}, {"lambda", "λ"}, {"mu", "μ"},    {"nu", "ν"},
      {"phi", "φ"},   {"pi", "π"},    {"rho", "ρ"},    {"sigma", "σ"}, {"tau", "τ"},
      {"theta", "θ"}, {"Pi", "Π"},    {"chi", "χ"},    {"omega", "ω"}};
  return kLetters;
}

std::string_view Subscript(char c) {
  static const std::map<char, std::string_view> kSubscripts = {
      {'0', "₀"}, {'1', "₁"}, {'2', "₂"}, {'3', "₃"}, {'4', "₄"}, {'5', "₅"}, {'6', "₆"},
      {'7', "₇"}, {'8', "₈"}, {'9', "₉"}, {'a', "ₐ"}, {'e', "ₑ"}, {'i', "ᵢ"}, {'j', "ⱼ"},
      {'k', "ₖ"}, {'m', "ₘ"}, {'n', "ₙ"}, {'o', "ₒ"}, {'p', "ₚ"}, {'r', "ᵣ"}, {'s', "ₛ"},
      {'t', "ₜ"}, {'u', "ᵤ"}, {'v', "ᵥ"}, {'x', "ₓ"}};
  const auto found = kSubscripts.find(c);
  return found == kSubscripts.end() ? std::string_view{} : found->second;
}

std::string Greek(std::string_view word) {
  const auto found = GreekLetters().find(word);
  return std::string(found == GreekLetters().end() ? word : found->second);
}

std::string PlainSubscript(std::string_view text) {
  std::string subscripts;
  for (const char c : text) {
    if (Subscript(c).empty()) return "_" + std::string(text);
    subscripts += Subscript(c);
  }
  return subscripts;
}

// A word of letters, digits and underscores: "sigma", "mu_r", "F_c".
std::string SymbolWord(std::string_view word, bool markup) {
  const std::size_t underscore = word.find('_');
  // A canonical name ("rolling_friction") stands in where a study gives no symbol.
  const bool symbol = underscore == std::string_view::npos ||
                      (underscore > 0 && word.size() - underscore <= 4 &&
                       word.find('_', underscore + 1) == std::string_view::npos);
  if (!symbol) return ReadableName(word);
  const std::string base = Greek(word.substr(0, underscore));
  if (underscore == std::string_view::npos || underscore + 1 == word.size()) return base;
  const std::string_view index = word.substr(underscore + 1);
  return markup ? base + "<sub>" + Greek(index) + "</sub>" : base + PlainSubscript(index);
}

std::string WithoutAscii(std::string_view symbol) {
  static constexpr std::pair<std::string_view, std::string_view> kSigns[] = {
      {"^2", "²"}, {"^3", "³"}, {"sqrt(", "√("}};
  std::string text(symbol);
  for (const auto& [ascii, sign] : kSigns) {
    for (auto at = text.find(ascii); at != std::string::npos; at = text.find(ascii, at)) {
      text.replace(at, ascii.size(), sign);
    }
  }
  return text;
}

std::string Symbol(std::string_view ascii, bool markup) {
  const std::string signs = WithoutAscii(ascii);
  const std::string_view symbol = signs;
  std::string text;
  std::size_t position = 0;
  while (position < symbol.size()) {
    std::size_t end = position;
    while (end < symbol.size() &&
           (std::isalnum(static_cast<unsigned char>(symbol[end])) || symbol[end] == '_')) {
      ++end;
    }
    if (end > position) {
      text += SymbolWord(symbol.substr(position, end - position), markup);
    } else {
      while (end < symbol.size() && !std::isalnum(static_cast<unsigned char>(symbol[end]))) ++end;
      const std::string_view between = symbol.substr(position, end - position);
      text += markup ? EscapeHtml(between) : std::string(between);
    }
    position = end;
  }
  return text;
}

std::string Superscript(int number) {
  static constexpr std::string_view kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = number < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(number))) text += kDigits[c - '0'];
  return text;
}

// Drops the zeros that end a decimal fraction.
std::string Trimmed(std::string number) {
  if (number.find('.') == std::string::npos) return number;
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number;
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : ValidUtf8(text)) {
    const auto code = static_cast<unsigned char>(c);
    if ((code < 0x20 && c != '\n' && c != '\t') || code == 0x7F) {
      escaped += kReplacement;
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (c == '\'') {
      escaped += "&#39;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string ReadableName(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  std::string text(dot == std::string_view::npos ? name : name.substr(dot + 1));
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string PrettyUnit(std::string_view unit) {
  if (unit == "1") return "";
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const bool after_letter = i > 0 && std::isalpha(static_cast<unsigned char>(unit[i - 1]));
    if (unit[i] == '2' && after_letter) {
      text += "²";
    } else if (unit[i] == '3' && after_letter) {
      text += "³";
    } else if (unit[i] == 'u' && !after_letter && i + 1 < unit.size() && unit[i + 1] != 'n') {
      text += "µ";
    } else {
      text += unit[i];
    }
  }
  return text;
}

std::string SymbolText(std::string_view symbol) { return Symbol(symbol, false); }
std::string SymbolHtml(std::string_view symbol) { return Symbol(symbol, true); }

std::string NumberText(double value, int digits) {
  if (!std::isfinite(value)) return "—";
  if (value == 0) return "0";
  if (value < 0) return "−" + NumberText(-value, digits);
  if (value < 1e-4 || value >= 1e6) {
    const std::string scientific = fmt::format("{:.{}e}", value, digits - 1);
    const std::size_t e = scientific.find('e');
    const std::string mantissa = Trimmed(scientific.substr(0, e));
    const std::string power = "10" + Superscript(std::stoi(scientific.substr(e + 1)));
    return mantissa == "1" ? power : mantissa + "×" + power;
  }
  const int exponent = static_cast<int>(std::floor(std::log10(value)));
  return Trimmed(fmt::format("{:.{}f}", value, std::max(0, digits - 1 - exponent)));
}

DisplayUnit DisplayUnitOf(std::string_view si_unit) {
  if (si_unit == "rad") return {"deg", 180 / std::numbers::pi};
  return {si_unit, 1};
}

std::string ValueText(double value, std::string_view unit, int digits) {
  const DisplayUnit display = DisplayUnitOf(unit);
  const std::string number = NumberText(value * display.per_si, digits);
  const std::string pretty = PrettyUnit(display.name);
  return pretty.empty() ? number : number + " " + pretty;
}

std::string DurationText(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "—";
  if (seconds < 60) return NumberText(seconds, 3) + " s";
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string CountText(int count, std::string_view singular, std::string_view plural) {
  if (count == 1) return fmt::format("1 {}", singular);
  return plural.empty() ? fmt::format("{} {}s", count, singular)
                        : fmt::format("{} {}", count, plural);
}

std::string Capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 32);
  return text;
}

std::string WithFullStop(std::string text) {
  if (!text.empty() && text.back() != '.' && text.back() != '!') text += '.';
  return text;
}

std::string Sentence(std::string text) { return Capitalised(WithFullStop(std::move(text))); }

std::string Enumerated(const std::vector<std::string>& items) {
  if (items.size() < 2) return items.empty() ? "" : items[0];
  return fmt::format("{} and {}", fmt::join(items.begin(), items.end() - 1, ", "), items.back());
}

}  // namespace powdercal
