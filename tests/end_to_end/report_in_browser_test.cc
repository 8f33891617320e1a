#include <gmock/gmock.h>

#include <regex>

#include "tests/support/program.h"

// The report as a reader's browser shows it, without any network: headless Chromium.

namespace powdercal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(ReportInBrowser, PlotsAppearAndNothingComplains) {
  const TemporaryFolder folder;
  const ProcessResult run =
      Powdercal({"run", "hastelloy_x_table3", "--out", (folder / "x").string()}, folder.path());
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const ProcessResult browser =
      RunProcess({.arguments = {"chromium", "--headless", "--no-sandbox", "--disable-gpu",
                                "--disable-quic", "--no-first-run",
                                "--disable-background-networking", "--disable-component-update",
                                "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND",
                                "--user-data-dir=" + (folder / "profile").string(),
                                "--virtual-time-budget=8000", "--enable-logging=stderr",
                                "--dump-dom", "file://" + (folder / "x/report.html").string()},
                  .time_limit = std::chrono::minutes(2),
                  .output_limit = 64 << 20});
  ASSERT_TRUE(browser.succeeded()) << browser.Describe() << "\n" << browser.output.substr(0, 2000);
  EXPECT_THAT(browser.output, Not(HasSubstr("CONSOLE")));
  EXPECT_THAT(browser.output, Not(HasSubstr("Uncaught")));
  // What Vega has drawn: marks of the convergence plot and of the response surface.
  const std::regex marks("mark-(symbol|line|rect)");
  const auto count =
      std::distance(std::sregex_iterator(browser.output.begin(), browser.output.end(), marks),
                    std::sregex_iterator());
  const auto canvases = std::regex_search(browser.output, std::regex("<canvas"));
  EXPECT_TRUE(count >= 4 || canvases) << count;
  EXPECT_THAT(browser.output, HasSubstr("o simulation was run"));
}

}  // namespace
}  // namespace powdercal
