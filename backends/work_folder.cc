#include "backends/work_folder.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "core/errors.h"

namespace powdercal {

void WriteWorkFile(const std::filesystem::path& path, std::string_view text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw InputError("cannot write the file", {.location = {path.string()}});
}

void LeaveWorkFolder(const RunContext& context, const Outcome& outcome, std::string_view output) {
  if (!outcome.ok() && outcome.reason != Reason::cancelled) {
    WriteWorkFile(context.work_folder / "outcome.txt",
                  fmt::format("{}: {}\n\n{}\n", ToString(outcome.reason), outcome.message, output));
  } else if (!context.keep_files) {
    std::error_code ignored;
    std::filesystem::remove_all(context.work_folder, ignored);
  }
}

}  // namespace powdercal
