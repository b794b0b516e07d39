#include "slicer/reader/stream/number.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

namespace plumbline {
namespace {

std::optional<double> parse(const std::string& text) {
  double value = 0;
  const char* stop = parse_real(text.data(), text.data() + text.size(), value);
  if (stop != text.data() + text.size()) return std::nullopt;
  return value;
}

TEST(ParseReal, AgreesWithTheCLibraryOnEveryNotation) {
  for (const char* text : {"0",
                           "-0",
                           "1",
                           "+1",
                           "-1",
                           "1.",
                           ".5",
                           "+.5",
                           "-.5",
                           "1e2",
                           "1E2",
                           "2.e1",
                           "1e+2",
                           "1e-2",
                           "1e01",
                           "0.1",
                           "123456789012345678901234567890",
                           "4.9e-324",
                           "1.7976931348623157e308",
                           "0.30000000000000004",
                           "00012",
                           "5e-5"}) {
    EXPECT_EQ(parse(text), std::strtod(text, nullptr)) << text;
  }
}

TEST(ParseReal, AgreesWithTheCLibraryOnRandomNumbers) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    char text[64];
    const double value = std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 400) - 230);
    std::snprintf(text, sizeof text, "%.*g", static_cast<int>(random() % 20) + 1, value);
    EXPECT_EQ(parse(text), std::strtod(text, nullptr)) << text;
  }
}

TEST(ParseReal, RoundsNumbersOfAnyLengthOnce) {
  std::mt19937_64 random(2);
  const auto digits = [&](std::uint64_t most) {
    std::string text;
    for (std::uint64_t left = random() % most + 1; left > 0; --left) text += static_cast<char>('0' + random() % 10);
    return text;
  };
  for (int i = 0; i < 50000; ++i) {
    std::string text = (random() % 2 == 0 ? "-" : "") + digits(12);
    if (random() % 4 != 0) text += "." + digits(12);
    if (random() % 2 != 0) text += (random() % 2 == 0 ? "e-" : "E") + std::to_string(random() % 30);
    const auto value = parse(text);
    ASSERT_TRUE(value.has_value()) << text;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(*value), std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)))
        << text;
  }
  EXPECT_EQ(parse("9007199254740993"), 9007199254740992.0);
  EXPECT_TRUE(std::signbit(*parse("-0.00")));
}

TEST(ParseReal, OverflowGivesInfinityAndUnderflowZero) {
  EXPECT_EQ(parse("1e400"), HUGE_VAL);
  EXPECT_EQ(parse("1e999999999999999999999999"), HUGE_VAL);
  EXPECT_EQ(parse("-1e400"), HUGE_VAL) << "the sign does not matter: the point is dropped";
  EXPECT_EQ(parse(std::string(400, '9')), HUGE_VAL);
  EXPECT_EQ(parse("0.001e400"), HUGE_VAL);
  EXPECT_EQ(parse("1e-400"), 0.0);
  EXPECT_EQ(parse("1e-999999999999999999999999"), 0.0);
  EXPECT_EQ(parse("0." + std::string(400, '0') + "1"), 0.0);
  EXPECT_EQ(parse("1000e-400"), 0.0);
  EXPECT_EQ(parse("0e999"), 0.0);
}

TEST(ParseReal, ReadsTheNamesOfNanAndInfinity) {
  for (const char* text : {"nan", "NaN", "-nan", "+nan", "nan(0x1)", "1.#QNAN", "1.#IND", "-1.#IND00", "1.#INF"}) {
    ASSERT_TRUE(parse(text).has_value()) << text;
    EXPECT_TRUE(std::isnan(*parse(text))) << text;
  }
  for (const char* text : {"inf", "+Inf", "-INFINITY"}) {
    ASSERT_TRUE(parse(text).has_value()) << text;
    EXPECT_TRUE(std::isinf(*parse(text))) << text;
  }
}

TEST(ParseReal, ReadsTheExponentsOfFortran) {
  for (const auto& [text, value] : {std::pair("1.0D+02", 100.0),
                                    {"-2.5d-1", -0.25},
                                    {"1D400", HUGE_VAL},
                                    {"3.D0", 3.0},
                                    {"0.12345678901234567890D+03", 123.45678901234568}}) {
    EXPECT_EQ(parse(text), value) << text;
  }
  for (const char* text : {"1D", "1.0D+", "D5", "1D2D3", "3d"}) EXPECT_FALSE(parse(text).has_value()) << text;
}

TEST(ParseReal, ReadsDecimalCommasOnlyWhereAsked) {
  for (const auto& [text, value] : {std::pair("1,5", 1.5),
                                    {"-0,25e1", -2.5},
                                    {"10,0D1", 100.0},
                                    {"1,5,2", 0.0},
                                    {"1.5,2", 0.0},
                                    {",5", 0.0},
                                    {"5,", 0.0},
                                    {"1,2.5", 0.0},
                                    {"12", 0.0}}) {
    const std::string word = text;
    double found = 0;
    const bool is_read =
        parse_decimal_comma(word.data(), word.data() + word.size(), found) == word.data() + word.size();
    EXPECT_EQ(is_read ? found : 0, value) << text;
  }
}

TEST(ParseReal, RefusesOtherWords) {
  for (const char* text : {"", "+", "-", ".", "e5", "+-1", "++1", "--1", "x1", "1x", "1e", "1,5", "0x10", "3.1+e2",
                           "1 ", " 1", "1.#", "1.#FOO", "1_000"}) {
    EXPECT_FALSE(parse(text).has_value()) << text;
  }
}

TEST(ParseCount, ReadsDigitsBelowTwoToThe64) {
  EXPECT_EQ(parse_count("0"), 0U);
  EXPECT_EQ(parse_count("18446744073709551615"), UINT64_MAX);
  for (const char* word : {"", "-1", "+1", "1.0", "1e3", "18446744073709551616", "12a"}) {
    EXPECT_FALSE(parse_count(word).has_value()) << word;
  }
}

}  // namespace
}  // namespace plumbline
