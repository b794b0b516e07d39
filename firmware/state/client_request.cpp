#include "firmware/state/client_request.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <utility>

#include "firmware/io/json_cursor.hpp"

namespace plumbline {
namespace {

/// A member's value. JSON has other kinds; none of them is allowed.
struct Value {
  enum class Kind : std::uint8_t { kText, kNumber, kTruth };
  Kind kind = Kind::kText;
  std::string_view text;
};

constexpr std::array<std::string_view, 6> kMembers = {"do", "id", "scan", "key", "value", "picture"};
enum Member : std::uint8_t { kDo, kId, kScan, kKey, kValue, kPicture };

tl::unexpected<Error> not_an_object() {
  return fail(
      ErrorCode::kMalformed,
      "not a flat JSON object of texts, numbers, true and false.\tSend one a line, such as {\"do\": \"pause\"}");
}

std::optional<Value> take_value(JsonCursor& cursor, std::span<char> room) {
  if (const auto text = cursor.take_text(room)) return Value{Value::Kind::kText, *text};
  if (const auto number = cursor.take_number()) return Value{Value::Kind::kNumber, *number};
  for (const std::string_view word : {"true", "false"}) {
    if (cursor.take_word(word)) return Value{Value::Kind::kTruth, word};
  }
  return std::nullopt;
}

/// A whole number from 0 to 2^53, which every reader of JSON can hold.
std::optional<std::uint64_t> whole_number(const Value& value) {
  std::uint64_t number = 0;
  const char* const end = value.text.data() + value.text.size();
  const auto [at, problem] = std::from_chars(value.text.data(), end, number);
  constexpr std::uint64_t kMost = std::uint64_t{1} << 53U;
  if (value.kind != Value::Kind::kNumber || problem != std::errc() || at != end || number > kMost) return std::nullopt;
  return number;
}

tl::unexpected<Error> wrong_value(std::string_view member, const char* allowed) {
  return fail(ErrorCode::kBadSetting, "%.*s: allowed is %s", static_cast<int>(member.size()), member.data(), allowed);
}

/// Stores a member's value.
Status store(Member member, const Value& value, ClientRequest& request, std::optional<std::uint64_t>& id) {
  switch (member) {
    case kDo: {
      const auto command = value.kind == Value::Kind::kText ? command_of(value.text) : std::nullopt;
      if (!command) {
        return wrong_value("do", "start, pause, resume, cancel, plate-empty, seen, offer, choose, set or picture");
      }
      request.command = *command;
      return {};
    }
    case kId: id = whole_number(value); return id ? Status() : Status(wrong_value("id", "a whole number, 0 to 2^53"));
    case kScan: {
      const auto number = whole_number(value);
      if (!number || *number == 0 || *number > PrinterRecord::kMostScans)
        return wrong_value("scan", "a number from 1 on");
      request.scan = static_cast<std::uint32_t>(*number);
      return {};
    }
    case kKey:
      if (value.kind != Value::Kind::kText) return wrong_value("key", "a text");
      request.key.add("%.*s", static_cast<int>(value.text.size()), value.text.data());
      return request.key.cut() ? Status(wrong_value("key", "a text of at most 31 bytes")) : Status();
    case kValue:
      request.value.add("%.*s", static_cast<int>(value.text.size()), value.text.data());
      return request.value.cut() ? Status(wrong_value("value", "a text of at most 63 bytes")) : Status();
    case kPicture: {
      const auto* const word = std::find(kPictureWords.begin(), kPictureWords.end(), value.text);
      if (value.kind != Value::Kind::kText || word == kPictureWords.end()) {
        return wrong_value("picture", "preview or layer");
      }
      request.picture = static_cast<PictureName>(word - kPictureWords.begin());
      return {};
    }
  }
  return {};
}

/// Whether a request has the members that its command needs, and no others.
Status check_members(const ClientRequest& request, const std::array<bool, kMembers.size()>& found) {
  if (!found[kDo])
    return fail(ErrorCode::kBadSetting, "there is no \"do\".\tSay what to do, such as {\"do\": \"pause\"}");
  const bool chooses = request.command == Command::kChoose;
  const bool sets = request.command == Command::kSet;
  const bool looks = request.command == Command::kPicture;
  if (found[kScan] == chooses && found[kKey] == sets && found[kValue] == sets && found[kPicture] == looks) return {};
  const auto word = to_string(request.command);
  const char* const needs = chooses ? "\"scan\", a number from the list of scans"
                            : sets  ? "\"key\" and \"value\""
                            : looks ? "\"picture\", preview or layer,"
                                    : "nothing";
  return fail(ErrorCode::kBadSetting, "%.*s needs %s beside \"do\" and \"id\"", static_cast<int>(word.size()),
              word.data(), needs);
}

}  // namespace

Expected<ClientRequest> parse_request(std::string_view line, std::optional<std::uint64_t>& id) {
  id.reset();
  ClientRequest request;
  std::array<bool, kMembers.size()> found{};
  std::array<char, 32> name_room;
  std::array<char, 128> value_room;
  JsonCursor cursor(line);
  if (!cursor.take('{')) return not_an_object();
  if (!cursor.take('}')) {
    do {
      const auto name = cursor.take_text(name_room);
      if (!name || !cursor.take(':')) return not_an_object();
      const auto value = take_value(cursor, value_room);
      if (!value) return not_an_object();
      const auto* const known = std::find(kMembers.begin(), kMembers.end(), *name);
      if (known == kMembers.end()) {
        return fail(ErrorCode::kBadSetting, "'%.*s': unknown member.\tKnown are do, id, scan, key, value and picture",
                    static_cast<int>(name->size()), name->data());
      }
      const auto member = static_cast<Member>(known - kMembers.begin());
      if (std::exchange(found[member], true)) return wrong_value(*name, "one");
      PLUMBLINE_TRY(store(member, *value, request, id));
    } while (cursor.take(','));
    if (!cursor.take('}')) return not_an_object();
  }
  if (!cursor.at_end()) return not_an_object();
  PLUMBLINE_TRY(check_members(request, found));
  return request;
}

}  // namespace plumbline
