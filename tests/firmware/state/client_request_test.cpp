#include "firmware/state/client_request.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

struct Parsed {
  Expected<ClientRequest> request;
  std::optional<std::uint64_t> id;
};

Parsed parse(std::string_view line) {
  std::optional<std::uint64_t> id = 99;
  auto request = parse_request(line, id);
  return {std::move(request), id};
}

TEST(ClientRequest, HasACommandAndWhatItNeeds) {
  for (std::size_t i = 0; i < kCommandCount; ++i) {
    const auto command = static_cast<Command>(i);
    if (command == Command::kChoose || command == Command::kSet || command == Command::kRemove ||
        command == Command::kOpen)
      continue;
    const auto parsed = parse("{\"do\":\"" + std::string(to_string(command)) + "\"}");
    ASSERT_TRUE(parsed.request) << parsed.request.error().message();
    EXPECT_EQ(parsed.request->command, command);
    EXPECT_EQ(parsed.id, std::nullopt);
  }
  const auto choose = parse(" {\t\"scan\" : 64 , \"id\":9007199254740992, \"do\": \"choose\" } \r");
  ASSERT_TRUE(choose.request) << choose.request.error().message();
  EXPECT_EQ(choose.request->scan, 64U);
  EXPECT_EQ(parse("{\"do\": \"open\", \"folder\": 0}").request.value().folder, 0U);
  EXPECT_EQ(parse("{\"do\": \"open\", \"folder\": 32}").request.value().folder, 32U);
  EXPECT_EQ(choose.id, 9007199254740992U);
  const auto set = parse(R"({"do": "set", "key": "\u0073cale", "value": -1.5e+3})");
  ASSERT_TRUE(set.request) << set.request.error().message();
  EXPECT_EQ(set.request->key.view(), "scale");
  EXPECT_EQ(set.request->value.view(), "-1.5e+3");
  EXPECT_EQ(parse(R"({"do":"mask","layer":4294967295})").request->layer, 4294967295U);
  EXPECT_EQ(parse(R"({"from":24576,"picture":"part","do":"picture"})").request->from, 24576U);
  const auto window = parse(R"({"do":"mask","layer":3,"x":16384,"y":7,"step":2})").request.value().window;
  EXPECT_EQ((std::array{window.column, window.row, window.step}), (std::array{16384U, 7U, 2U}));
  EXPECT_EQ(parse(R"({"do":"picture","picture":"proposal","proposal":4})").request->which, 4U);
  EXPECT_EQ(parse(R"({"do":"report","from":24576})").request->from, 24576U);
  EXPECT_EQ(parse(R"({"do":"code","code":"0482913"})").request->code.view(), "0482913");
  EXPECT_EQ(parse(R"({"do":"code","code":""})").request->code.view(), "");
  const auto upload = parse(R"({"do":"upload","name":"../b\u00fcst.ply","bytes":9007199254740992})");
  ASSERT_TRUE(upload.request) << "the daemon looks at the name";
  EXPECT_EQ(upload.request->name.view(), "../b\xc3\xbcst.ply");
  EXPECT_EQ(upload.request->bytes, 9007199254740992U);
  EXPECT_EQ(parse(R"({"do":"remove","name":"../b.ply"})").request->name.view(), "../b.ply");
  EXPECT_EQ(parse(R"({"do":"filled"})").request->ml, std::nullopt);
  EXPECT_EQ(parse(R"({"do":"filled","ml":12.5})").request->ml, 12.5);
  for (const char* const wrong :
       {R"({"do":"filled","ml":-1})", R"({"do":"filled","ml":"1"})", R"({"do":"start","ml":1})"}) {
    EXPECT_FALSE(parse(wrong).request) << wrong;
  }
  EXPECT_EQ(parse(R"({"do":"set","key":"fit","value":true})").request->value.view(), "true");
  EXPECT_EQ(parse(R"({"do":"set","key":"profile","value":"\ud83d\ude00 \"\\\/"})").request->value.view(),
            "\xf0\x9f\x98\x80 \"\\/");
}

TEST(ClientRequest, SaysWhatItIsMeantFor) {
  const auto start = parse(R"({"do":"start","for":"00000000000000ff"})");
  ASSERT_TRUE(start.request) << start.request.error().message();
  EXPECT_EQ(start.request->about, 255U);
  EXPECT_EQ(parse(R"({"do":"set","key":"scale","value":2,"for":"ffffffffffffffff"})").request->about, UINT64_MAX);
  EXPECT_EQ(parse(R"({"do":"mask","layer":1,"job":"0123456789abcdef"})").request->job, 0x0123456789abcdefU);
  for (const char* id : {"\"\"", "255", "\"ff\"", "\"0000000000000000\"", "\"00000000000000FF\"",
                         "\"00000000000000ff0\"", "\"0x000000000000ff\"", "\"-0000000000000ff\"", "true"}) {
    const auto wrong = parse(std::string(R"({"do":"start","for":)") + id + "}");
    ASSERT_FALSE(wrong.request) << id;
    EXPECT_THAT(wrong.request.error().message(), HasSubstr("16 hexadecimal digits"));
  }
  EXPECT_FALSE(parse(R"({"do":"start","job":"00000000000000ff"})").request)
      << "a picture is of a job, a command for one";
  EXPECT_FALSE(parse(R"({"do":"mask","layer":1,"for":"00000000000000ff"})").request);
  TextBuffer<200> line;
  ASSERT_TRUE(write_request(line, *start.request, 7));
  EXPECT_EQ(parse(line.view().substr(0, line.view().size() - 1)).request->about, 255U) << line.view();
}

struct Wrong {
  const char* line;
  const char* said;
};

TEST(ClientRequest, SaysWhatIsWrong) {
  constexpr const char* kForm = "not a flat JSON object";
  const Wrong wrong[] = {
      {"", kForm},
      {"null", kForm},
      {"[]", kForm},
      {"{", kForm},
      {"{}", "there is no \"do\""},
      {"{\"id\":1}", "there is no \"do\""},
      {"{\"do\":\"start\"", kForm},
      {"{\"do\":\"start\",}", kForm},
      {"{\"do\":\"start\"}}", kForm},
      {"{\"do\":\"start\"}{\"do\":\"start\"}", kForm},
      {"{'do':'start'}", kForm},
      {"{\"do\":{\"do\":\"start\"}}", kForm},
      {"{\"do\":[\"start\"]}", kForm},
      {"{\"do\":null}", kForm},
      {"{\"do\":\"st\xff\"}", kForm},
      {"{\"do\":\"st\xc0\xaf\"}", kForm},
      {"{\"do\":\"\\ud800\"}", kForm},
      {"{\"do\":\"\\x\"}", kForm},
      {"{\"do\":\"start\",\"id\":01}", kForm},
      {"{\"do\":\"start\",\"id\":.5}", kForm},
      {"{\"do\":\"start\",\"id\":NaN}", kForm},
      {"{\"do\":\"START\"}", "do: allowed is start, pause"},
      {"{\"do\":1}", "do: allowed is start, pause"},
      {"{\"do\":\"start\",\"do\":\"cancel\"}", "do: allowed is one"},
      {"{\"do\":\"start\",\"id\":-1}", "id: allowed is a whole number"},
      {"{\"do\":\"start\",\"id\":1.5}", "id: allowed is a whole number"},
      {"{\"do\":\"start\",\"id\":9007199254740993}", "id: allowed is a whole number"},
      {"{\"do\":\"start\",\"file\":1}", "'file': unknown member"},
      {"{\"do\":\"start\",\"scan\":1}", "start needs nothing beside"},
      {"{\"do\":\"open\"}", "open needs \"folder\""},
      {"{\"do\":\"open\",\"folder\":33}", "folder: allowed is"},
      {"{\"do\":\"start\",\"folder\":1}", "start needs nothing"},
      {"{\"do\":\"choose\"}", "choose needs \"scan\""},
      {"{\"do\":\"choose\",\"scan\":0}", "scan: allowed is"},
      {"{\"do\":\"choose\",\"scan\":65}", "scan: allowed is"},
      {"{\"do\":\"set\",\"key\":\"scale\"}", "set needs \"key\" and \"value\""},
      {"{\"do\":\"mask\"}", "mask needs \"layer\""},
      {"{\"do\":\"mask\",\"layer\":-1}", "layer: allowed is"},
      {"{\"do\":\"mask\",\"layer\":4294967296}", "layer: allowed is"},
      {"{\"do\":\"mask\",\"layer\":1,\"scan\":1}", "mask needs \"layer\""},
      {"{\"do\":\"picture\",\"picture\":\"part\"}", "the picture \"part\", and no other, needs \"from\""},
      {"{\"do\":\"picture\",\"picture\":\"layer\",\"from\":1}", "the picture \"part\", and no other, needs \"from\""},
      {"{\"do\":\"start\",\"from\":1}", "start needs nothing"},
      {"{\"do\":\"mask\",\"layer\":1,\"x\":16385}", "x: allowed is a number of pixels"},
      {"{\"do\":\"mask\",\"layer\":1,\"step\":-1}", "step: allowed is a number of pixels"},
      {"{\"do\":\"picture\",\"picture\":\"proposal\",\"proposal\":5}", "proposal: allowed is"},
      {"{\"do\":\"picture\",\"picture\":\"issues\",\"proposal\":1}", "\"proposal\" is for the picture"},
      {"{\"do\":\"propose\",\"scan\":1}", "propose needs nothing beside"},
      {"{\"do\":\"report\"}", "report needs \"from\""},
      {"{\"do\":\"report\",\"from\":\"0\"}", "from: allowed is"},
      {"{\"do\":\"code\",\"code\":482913}", "code: allowed is"},
      {"{\"do\":\"code\",\"code\":\"12345678\"}", "code: allowed is"},
      {"{\"do\":\"code\",\"code\":\"12 34\"}", "code: allowed is"},
      {"{\"do\":\"upload\",\"name\":\"a.ply\"}", "upload needs \"name\" and \"bytes\""},
      {"{\"do\":\"upload\",\"name\":1,\"bytes\":1}", "name: allowed is a text"},
      {"{\"do\":\"upload\",\"name\":\"a.ply\",\"bytes\":-1}", "bytes: allowed is"},
      {"{\"do\":\"remove\"}", "remove needs \"name\""},
      {"{\"do\":\"remove\",\"name\":true}", "name: allowed is a text"},
      {"{\"do\":\"remove\",\"name\":\"a.ply\",\"bytes\":1}", "remove needs \"name\""},
      {"{\"do\":\"start\",\"bytes\":1}", "start needs nothing beside"},
      {"{\"do\":\"set\",\"key\":1,\"value\":1}", "key: allowed is a text"},
      {"{\"do\":\"set\",\"key\":\"a key that is longer than any key is\",\"value\":1}", "at most 31 bytes"},
  };
  for (const Wrong& one : wrong) {
    const auto parsed = parse(one.line);
    ASSERT_FALSE(parsed.request) << one.line;
    EXPECT_THAT(parsed.request.error().message(), HasSubstr(one.said)) << one.line;
  }
  EXPECT_EQ(parse("{\"id\":5,\"do\":\"nothing\"}").id, 5U) << "so that the reply finds its request";
  EXPECT_FALSE(parse("{\"do\":" + std::string(900, '[') + "}").request) << "nested deeply";
  EXPECT_FALSE(parse("{\"do\":\"" + std::string(900, 's') + "\"}").request) << "a long text";
}

}  // namespace
}  // namespace plumbline::firmware
