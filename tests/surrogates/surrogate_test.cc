#include "surrogates/surrogate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"

namespace powdercal {
namespace {

TEST(SurrogateTest, EveryNameMakesASurrogateOfThatName) {
  EXPECT_TRUE(std::is_sorted(SurrogateNames().begin(), SurrogateNames().end()));
  for (const std::string& name : SurrogateNames()) EXPECT_EQ(MakeSurrogate(name)->name(), name);
}

TEST(SurrogateTest, AnUnknownNameIsAnErrorWithTheNearestName) {
  try {
    MakeSurrogate("gausian_process");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().suggestion, "gaussian_process");
  }
}

}  // namespace
}  // namespace powdercal
