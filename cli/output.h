#pragma once

#include <fmt/format.h>

#include <string_view>

namespace powdercal::cli {

// Writing never throws: neither a reader that went away nor a full disk is a reason to lose a
// study.

/// Opens /dev/null in the place of a standard stream that is closed; the next file would get its
/// number, and what is said to people would end up in the ledger. Call it first of all.
void OpenStandardStreams();

void WriteOutput(std::string_view text);
void WriteError(std::string_view text);

/// To standard output: results.
template <typename... T>
void Print(fmt::format_string<T...> format, T&&... arguments) {
  WriteOutput(fmt::format(format, std::forward<T>(arguments)...));
}

/// To standard error: progress, warnings, errors.
template <typename... T>
void Say(fmt::format_string<T...> format, T&&... arguments) {
  WriteError(fmt::format(format, std::forward<T>(arguments)...));
}

/// Whether standard output is a terminal, where colours may be used: not with NO_COLOR set.
bool OutputIsTerminal();

/// Writes what is still buffered. False, with errno, if something that was printed could not be
/// written, unless its reader just had enough (`| head`).
bool FlushOutput();

}  // namespace powdercal::cli
