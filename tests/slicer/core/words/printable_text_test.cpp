#include "slicer/core/words/printable_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "slicer/core/error.hpp"

namespace plumbline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string shown(std::string_view raw) { return std::string(PrintableText(raw).view()); }

TEST(PrintableText, KeepsWhatPeopleWrite) {
  for (const char* text : {"", "bust.ply", "C:\\scans\\bust 2.ply",
                           "b\u00fcste \u80f8\u50cf \u0431\u044e\u0441\u0442.ply", "\U0001F5FF"}) {
    EXPECT_EQ(shown(text), text);
  }
}

TEST(PrintableText, ANameForgesNoLineOfALog) {
  EXPECT_EQ(shown("a.ply\nplumblined: PL-301, lamp stuck on"), "a.ply\\x0aplumblined: PL-301, lamp stuck on");
  EXPECT_EQ(shown("a\r\x1b[2K\x1b[31mx"), "a\\x0d\\x1b[2K\\x1b[31mx");
  EXPECT_EQ(shown(std::string_view("a\0b\x7f\tc", 6)), "a\\x00b\\x7f\\x09c");
  EXPECT_EQ(shown("\u2028x\u2029\u0085"), "\\u{2028}x\\u{2029}\\u{85}")
      << "C1 and the separators of lines and paragraphs";
}

TEST(PrintableText, ShowsWhatReordersOrHidesCharacters) {
  EXPECT_EQ(shown("scan\u202eylp.exe\u202c"), "scan\\u{202e}ylp.exe\\u{202c}");
  EXPECT_EQ(shown("\u2066a\u2069\u200f\u061c"), "\\u{2066}a\\u{2069}\\u{200f}\\u{61c}");
  EXPECT_EQ(shown("bust\u200b.ply\ufeff\u00ad"), "bust\\u{200b}.ply\\u{feff}\\u{ad}");
}

TEST(PrintableText, ShowsBytesThatAreNotUtf8) {
  // A lone byte, a truncated sequence, an overlong newline, half of a UTF-16 pair, and a code above the last.
  EXPECT_EQ(shown("\xffx"), "\\xffx");
  EXPECT_EQ(shown("\xe2\x82"), "\\xe2\\x82");
  EXPECT_EQ(shown("\xc0\x8a"), "\\xc0\\x8a");
  EXPECT_EQ(shown("\xed\xa0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(shown("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

TEST(PrintableText, CutsBetweenCharactersAndSaysSo) {
  EXPECT_EQ(PrintableText("abcdef", 6).view(), "abcdef");
  EXPECT_EQ(PrintableText("abcdefg", 6).view(), "abc...");
  EXPECT_EQ(PrintableText("ab\u00fc\u00fc\u00fc", 7).view(), "ab\u00fc...");
  EXPECT_EQ(PrintableText("a\x1b\x1b", 8).view(), "a\\x1b...");
  EXPECT_EQ(PrintableText("abcdef", 2).view(), "..");
  const PrintableText long_one(std::string(5000, '\n'));
  EXPECT_LT(long_one.view().size(), PrintableText::kCapacity);
  EXPECT_EQ(std::string_view(long_one.c_str()), long_one.view());
}

TEST(PrintableText, OfAnyBytesIsPrintableAndStaysTheSame) {
  std::mt19937 random(7);
  for (int round = 0; round < 20'000; ++round) {
    std::string raw(random() % 40, '\0');
    // Half of the bytes are those of which UTF-8 is made.
    for (char& c : raw) c = static_cast<char>(random() % 2 == 0 ? random() : 0x80U + random() % 0x80U);
    const std::string once = shown(raw);
    ASSERT_EQ(shown(once), once);
    for (const char c : once) {
      ASSERT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7F);
    }
  }
}

TEST(PrintableText, IsWhatEveryErrorIsMadeOf) {
  const Error error = Error::format(ErrorCode::kCannotOpen, "%s: missing.\tLook for %s", "a\nb", "c\x1b[0m");
  EXPECT_STREQ(error.message(), "a\\x0ab: missing. Look for c\\x1b[0m");
  EXPECT_EQ(error.finding(), "a\\x0ab: missing");
  EXPECT_EQ(error.advice(), "Look for c\\x1b[0m");
  const Error outer = error.with_prefix("d\ne");
  EXPECT_EQ(outer.advice(), "Look for c\\x1b[0m");
  EXPECT_EQ(outer.finding(), "d\\x0ae: a\\x0ab: missing");
  EXPECT_THAT(Error::format(ErrorCode::kCannotOpen, "%s", std::string(1000, '\n').c_str()).message(),
              Not(HasSubstr("\n")));
}

}  // namespace
}  // namespace plumbline
