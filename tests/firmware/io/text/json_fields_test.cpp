#include "firmware/io/text/json_fields.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>

#include "firmware/io/text/text_sink.hpp"

namespace plumbline::firmware {
namespace {

struct Pixel {
  std::uint32_t column = 0;
  double doubled() const { return 2.0 * column; }
};

struct Sample {
  FixedText<16> name;
  std::optional<Pixel> pixel;
  std::optional<std::chrono::nanoseconds> time;
};

constexpr JsonField<Pixel> kPixelFields[] = {{"column", member<&Pixel::column>}, {"doubled", member<&Pixel::doubled>}};

constexpr JsonField<Sample> kSampleFields[] = {
    {"name", member<&Sample::name>},
    {"pixel", object<&Sample::pixel, kPixelFields>},
    {"time_s", rounded<&Sample::time>},
    {"named", [](auto& json, auto& sample) { json.value(!sample.name.view().empty()); }},
};

TEST(JsonFields, WriteMembersAndResultsInTheirOrder) {
  Sample samples[2];
  samples[1].name.add("b");
  samples[1].pixel = {.column = 3};
  samples[1].time = std::chrono::nanoseconds(1'234'567'890);
  TextBuffer<400> text;
  JsonWriter json(text);
  write_objects(json, kSampleFields, samples);
  ASSERT_TRUE(json.finish());
  EXPECT_EQ(text.view(),
            "[{\"name\": \"\", \"pixel\": null, \"time_s\": null, \"named\": false}, "
            "{\"name\": \"b\", \"pixel\": {\"column\": 3, \"doubled\": 6}, \"time_s\": 1.235, \"named\": true}]\n");
}

}  // namespace
}  // namespace plumbline::firmware
