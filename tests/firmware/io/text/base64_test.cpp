#include "firmware/io/text/base64.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>
#include <vector>

namespace plumbline::firmware {
namespace {

std::optional<std::string> decoded(std::string_view text, std::size_t room = 64) {
  std::vector<std::byte> bytes(room);
  const auto size = read_base64(text, bytes);
  if (!size) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(bytes.data()), *size);
}

// RFC 4648, section 10.
TEST(Base64, HasTheValuesOfItsStandard) {
  const std::array<std::pair<std::string, std::string>, 7> known = {{{"", ""},
                                                                     {"f", "Zg=="},
                                                                     {"fo", "Zm8="},
                                                                     {"foo", "Zm9v"},
                                                                     {"foob", "Zm9vYg=="},
                                                                     {"fooba", "Zm9vYmE="},
                                                                     {"foobar", "Zm9vYmFy"}}};
  for (const auto& [bytes, text] : known) {
    std::array<char, 8> out;
    const auto size = write_base64(std::as_bytes(std::span(bytes)), out);
    ASSERT_TRUE(size);
    EXPECT_EQ(std::string(out.data(), *size), text);
    EXPECT_EQ(decoded(text), bytes);
  }
}

TEST(Base64, ReadsBackWhatItWrote) {
  std::mt19937 random(27);
  for (std::size_t size = 0; size < 200; ++size) {
    std::string bytes(size, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    std::array<char, 300> out;
    const auto written = write_base64(std::as_bytes(std::span(bytes)), out);
    ASSERT_TRUE(written);
    EXPECT_EQ(decoded({out.data(), *written}, size), bytes);
    EXPECT_EQ(size > 0 ? decoded({out.data(), *written}, size - 1) : std::nullopt, std::nullopt) << "too little room";
  }
}

TEST(Base64, RefusesWhatIsNone) {
  for (const char* const text : {"Z", "Zg=", "Zg", "Z===", "====", "Zm9v\n", "Zm9%", "Zg==Zg==", "Zm-_"}) {
    EXPECT_EQ(decoded(text), std::nullopt) << text;
  }
  std::array<char, 3> small;
  EXPECT_EQ(write_base64(std::as_bytes(std::span("f", 1)), small), std::nullopt);
}

}  // namespace
}  // namespace plumbline::firmware
