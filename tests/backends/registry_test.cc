#include "backends/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/errors.h"

namespace powdercal {
namespace {

using ::testing::HasSubstr;

TEST(BackendRegistry, IsSortedAndMakesWhatItNames) {
  const auto names = BackendNames();
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  EXPECT_NE(std::find(names.begin(), names.end(), "table"), names.end());
  for (const std::string& name : names) EXPECT_EQ(MakeBackend(name)->name(), name);
}

TEST(BackendRegistry, BackendsSayWhetherTheyCanRun) {
  for (const std::string& name : BackendNames()) {
    const Availability availability = MakeBackend(name)->availability();
    EXPECT_NE(availability.available, availability.version.empty()) << name;
    EXPECT_EQ(availability.available, availability.why_not.empty()) << name;
  }
}

TEST(BackendRegistry, SuggestsTheNearestName) {
  try {
    MakeBackend("tabel");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("unknown backend 'tabel'"), HasSubstr("did you mean 'table'?")));
  }
}

}  // namespace
}  // namespace powdercal
