#include "core/text.h"

#include <gtest/gtest.h>

#include <string>

namespace powdercal {
namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";

TEST(ValidUtf8, LeavesValidTextAlone) {
  const std::string text = "plain, µm, Φ, 漢, 🙂, and a zero byte: " + std::string(1, '\0');
  EXPECT_EQ(ValidUtf8(text), text);
  EXPECT_EQ(ValidUtf8(""), "");
}

TEST(ValidUtf8, ReplacesBadBytesOnly) {
  const std::string bad = kReplacement;
  EXPECT_EQ(ValidUtf8("a\xFFz"), "a" + bad + "z");
  EXPECT_EQ(ValidUtf8("\xC3z"), bad + "z");               // sequence broken off by a letter
  EXPECT_EQ(ValidUtf8("z\xE2\x82"), "z" + bad + bad);     // and by the end
  EXPECT_EQ(ValidUtf8("\xC0\xAF"), bad + bad);            // overlong
  EXPECT_EQ(ValidUtf8("\xED\xA0\x80"), bad + bad + bad);  // surrogate
  EXPECT_EQ(ValidUtf8("\xE9t\xE9"), bad + "t" + bad);     // Latin-1
}

TEST(CountCharacters, CountsCodePoints) {
  EXPECT_EQ(CountCharacters("d [µm]"), 6);
  EXPECT_EQ(CountCharacters("🙂"), 1);
  EXPECT_EQ(CountCharacters(""), 0);
}

}  // namespace
}  // namespace powdercal
