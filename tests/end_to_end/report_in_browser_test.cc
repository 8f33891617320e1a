#include <gmock/gmock.h>

#include <regex>

#include "tests/support/program.h"

// The report as a reader's browser shows it, without any network: headless Chromium.

namespace powdercal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// The page's elements once its scripts have run, which must not have complained.
std::string Rendered(const std::filesystem::path& page, const TemporaryFolder& folder) {
  const ProcessResult browser =
      RunProcess({.arguments = {"chromium", "--headless", "--no-sandbox", "--disable-gpu",
                                "--disable-quic", "--no-first-run",
                                "--disable-background-networking", "--disable-component-update",
                                "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND",
                                "--user-data-dir=" + (folder / "profile").string(),
                                "--virtual-time-budget=8000", "--enable-logging=stderr",
                                "--dump-dom", "file://" + page.string()},
                  .time_limit = std::chrono::minutes(2),
                  .output_limit = 64 << 20});
  EXPECT_TRUE(browser.succeeded()) << browser.Describe() << "\n" << browser.output.substr(0, 2000);
  EXPECT_THAT(browser.output, Not(HasSubstr("CONSOLE")));
  EXPECT_THAT(browser.output, Not(HasSubstr("Uncaught")));
  return browser.output;
}

// What Vega has drawn.
void ExpectMarks(const std::string& page, int least) {
  const std::regex marks("mark-(symbol|line|rect)");
  const auto count =
      std::distance(std::sregex_iterator(page.begin(), page.end(), marks), std::sregex_iterator());
  const auto canvases = std::regex_search(page, std::regex("<canvas"));
  EXPECT_TRUE(count >= least || canvases) << count;
}

TEST(ReportInBrowser, PlotsAppearAndNothingComplains) {
  const TemporaryFolder folder;
  const ProcessResult run =
      Powdercal({"run", "hastelloy_x_table3", "--out", (folder / "x").string()}, folder.path());
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const std::string page = Rendered(folder / "x/report.html", folder);
  ExpectMarks(page, 4);  // of the convergence plot and of the response surface
  EXPECT_THAT(page, HasSubstr("o simulation was run"));
}

TEST(ReportInBrowser, ComparisonOfOptimizersIsDrawn) {
  const TemporaryFolder folder;
  const ProcessResult run =
      Powdercal({"compare", "hastelloy_x_table3", "--optimizers", "bayesian,random", "--seeds", "3",
                 "--evaluations", "8", "--out", (folder / "x").string()},
                folder.path());
  ASSERT_EQ(run.exit_status, 0) << run.output;
  const std::string page = Rendered(folder / "x/comparison.html", folder);
  ExpectMarks(page, 8);  // of the four plots
}

}  // namespace
}  // namespace powdercal
