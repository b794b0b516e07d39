#include "firmware/io/text/json_writer.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "firmware/io/output_file.hpp"
#include "tests/firmware/support/job_fixture.hpp"

namespace plumbline::firmware {
namespace {

/// The text that `write` produces.
template <class Write>
std::string written(Write write) {
  const TemporaryFolder folder;
  const std::string path = folder / "x.json";
  auto file = OutputFile::create(path.c_str());
  EXPECT_TRUE(file.has_value());
  JsonWriter json(*file);
  write(json);
  EXPECT_TRUE(json.finish().has_value());
  return read_text(path);
}

TEST(JsonWriter, PutsObjectsOnSeveralLinesAndRowsOnOne) {
  const std::string text = written([](JsonWriter& json) {
    json.begin_object();
    json.member("a", 1U);
    json.key("b");
    json.begin_array(JsonWriter::Layout::kOneLine);
    json.value(true);
    json.null();
    json.value("c");
    json.end_array();
    json.key("empty");
    json.begin_object();
    json.end_object();
    json.end_object();
  });
  EXPECT_EQ(text, "{\n  \"a\": 1,\n  \"b\": [true, null, \"c\"],\n  \"empty\": {}\n}\n");
}

TEST(JsonWriter, WritesNumbersThatReadBackAsTheSameBits) {
  for (const double number :
       {0.1, -1.0 / 3, 6.02214076e23, std::numeric_limits<double>::min(), std::numeric_limits<double>::max(), -0.0}) {
    const std::string text = written([&](JsonWriter& json) { json.value(number); });
    EXPECT_EQ(std::stod(text), number) << text;
  }
  EXPECT_EQ(written([](JsonWriter& json) { json.value(0.05F); }), "0.05\n");
  EXPECT_EQ(written([](JsonWriter& json) { json.value(std::numeric_limits<std::uint64_t>::max()); }),
            "18446744073709551615\n");
}

TEST(JsonWriter, WritesNullForNanAndInfinity) {
  EXPECT_EQ(written([](JsonWriter& json) { json.value(std::numeric_limits<double>::quiet_NaN()); }), "null\n");
  EXPECT_EQ(written([](JsonWriter& json) { json.value(-std::numeric_limits<float>::infinity()); }), "null\n");
}

TEST(JsonWriter, WritesHashesAsSixteenDigits) {
  EXPECT_EQ(written([](JsonWriter& json) { json.hex(0x0123456789abcdefU); }), "\"0123456789abcdef\"\n");
  EXPECT_EQ(written([](JsonWriter& json) { json.hex(0); }), "\"0000000000000000\"\n");
}

TEST(JsonWriter, EscapesQuotesAndShowsControlCharacters) {
  EXPECT_EQ(written([](JsonWriter& json) { json.value("a\"b\\c\n\x7f"); }), "\"a\\\"b\\\\c\\\\x0a\\\\x7f\"\n");
  EXPECT_EQ(written([](JsonWriter& json) { json.value("b\xC3\xBCste \xF0\x9F\x97\xBF"); }),
            "\"b\xC3\xBCste \xF0\x9F\x97\xBF\"\n");
}

TEST(JsonWriter, ShowsBytesThatAreNotUtf8) {
  EXPECT_EQ(written([](JsonWriter& json) { json.value("\xFFx\xE2\x82"); }), "\"\\\\xffx\\\\xe2\\\\x82\"\n");
}

TEST(JsonWriter, WritesMoreThanItsBufferHolds) {
  const std::string long_text(1000, 'x');
  std::string expected = "[";
  for (int i = 0; i < 10; ++i) expected += (i == 0 ? "\"" : ", \"") + long_text + "\"";
  EXPECT_EQ(written([&](JsonWriter& json) { json.value(std::vector<std::string>(10, long_text)); }), expected + "]\n");
}

TEST(JsonWriter, ReportsAFullDiskAtTheEnd) {
  auto file = OutputFile::create("/dev/full");
  ASSERT_TRUE(file.has_value());
  JsonWriter json(*file);
  json.value("x");
  const auto done = json.finish();
  ASSERT_FALSE(done.has_value());
  EXPECT_EQ(done.error().code(), ErrorCode::kCannotWrite);
  EXPECT_NE(std::string(done.error().message()).find("/dev/full: cannot be written: No space left on device"),
            std::string::npos)
      << done.error().message();
}

}  // namespace
}  // namespace plumbline::firmware
