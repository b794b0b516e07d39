#include "firmware/state/client_request.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/json_cursor.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "slicer/core/numbers/to_number.hpp"

namespace plumbline::firmware::inline state {
namespace {

static_assert(kProposalCount == 5, "the messages name the last one");

/// A member's value. JSON has other kinds; none of them is allowed.
struct Value {
  enum class Kind : std::uint8_t { kText, kNumber, kTruth };
  Kind kind = Kind::kText;
  std::string_view text;
};

constexpr std::array<std::string_view, 20> kMembers = {"do",   "id",   "scan",  "key",  "value", "picture",  "layer",
                                                       "from", "code", "print", "name", "bytes", "proposal", "folder",
                                                       "ml",   "for",  "job",   "x",    "y",     "step"};
enum RequestMember : std::uint8_t {
  kDo,
  kId,
  kScan,
  kKey,
  kValue,
  kPicture,
  kLayer,
  kFrom,
  kCode,
  kPrint,
  kName,
  kBytes,
  kProposal,
  kFolder,
  kMl,
  kFor,
  kJob,
  kX,
  kY,
  kStep
};

/// The members that a command needs beside "do", and a reminder of them.
struct Needs {
  std::uint32_t members = 0;  ///< bit m: member m
  const char* words = "nothing";
  std::uint32_t allowed = 0;  ///< members that it may have as well
};

constexpr std::uint32_t bit(RequestMember member) { return std::uint32_t{1} << member; }

Needs needs_of(Command command) {
  switch (command) {
    case Command::kChoose: return {bit(kScan), "\"scan\", a number from the list of scans"};
    case Command::kOpen: return {bit(kFolder), "\"folder\", a number from the list of folders, or 0,"};
    case Command::kSet: return {bit(kKey) | bit(kValue), "\"key\" and \"value\""};
    case Command::kPicture:
      return {bit(kPicture), "\"picture\", preview, issues, layer, part, proposal or scan,",
              bit(kPrint) | bit(kFrom) | bit(kProposal) | bit(kScan) | bit(kJob)};
    case Command::kMask:
      return {bit(kLayer), "\"layer\", a number from 0 on,", bit(kJob) | bit(kX) | bit(kY) | bit(kStep)};
    case Command::kReport: return {bit(kFrom), "\"from\", a number of bytes from 0 on,", bit(kPrint) | bit(kJob)};
    case Command::kCode: return {bit(kCode), "\"code\", up to 7 digits,"};
    case Command::kRemove: return {bit(kName), "\"name\", that of \"stored\" in the state,"};
    case Command::kFilled: return {0, "no other than \"ml\"", bit(kMl)};
    case Command::kUpload: return {bit(kName) | bit(kBytes), "\"name\" and \"bytes\""};
    case Command::kStart:
    case Command::kPause:
    case Command::kResume:
    case Command::kCancel:
    case Command::kPlateEmpty:
    case Command::kSeen:
    case Command::kPropose:
    case Command::kSettings:
    case Command::kOffer: return {};
  }
  return {};
}

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
  constexpr std::uint64_t kMost = std::uint64_t{1} << 53U;
  const auto number = to_number<std::uint64_t>(value.text);
  return value.kind == Value::Kind::kNumber && number <= kMost ? number : std::nullopt;
}

tl::unexpected<Error> wrong_value(std::string_view member, const char* allowed) {
  return fail(ErrorCode::kBadSetting, "%.*s: allowed is %s", static_cast<int>(member.size()), member.data(), allowed);
}

/// Stores a member's value.
Status store(RequestMember member, const Value& value, ClientRequest& request, std::optional<std::uint64_t>& id) {
  switch (member) {
    case kDo: {
      const auto command = value.kind == Value::Kind::kText ? command_of(value.text) : std::nullopt;
      if (!command) {
        return wrong_value("do",
                           "start, pause, resume, cancel, plate-empty, seen, offer, choose, set, remove, propose, "
                           "open, settings, filled, picture, "
                           "mask, report, code or upload");
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
    case kFolder: {
      const auto number = whole_number(value);
      if (!number || *number > kMostListedFolders) return wrong_value("folder", "a number from 0 on");
      request.folder = static_cast<std::uint32_t>(*number);
      return {};
    }
    case kKey:
      if (value.kind != Value::Kind::kText) return wrong_value("key", "a text");
      request.key.add("%.*s", static_cast<int>(value.text.size()), value.text.data());
      return request.key.cut() ? Status(wrong_value("key", "a text of at most 31 bytes")) : Status();
    case kValue:
      request.value.add("%.*s", static_cast<int>(value.text.size()), value.text.data());
      return request.value.cut() ? Status(wrong_value("value", "a text of at most 899 bytes")) : Status();
    case kPicture: {
      const auto* const word = std::find(kPictureWords.begin(), kPictureWords.end(), value.text);
      if (value.kind != Value::Kind::kText || word == kPictureWords.end()) {
        return wrong_value("picture", "preview, issues, layer, part, proposal or scan");
      }
      request.picture = static_cast<PictureName>(word - kPictureWords.begin());
      return {};
    }
    case kLayer: {
      const auto number = whole_number(value);
      if (!number || *number > UINT32_MAX) return wrong_value("layer", "a number from 0 on");
      request.layer = static_cast<std::uint32_t>(*number);
      return {};
    }
    case kX:
    case kY:
    case kStep: {
      const auto number = whole_number(value);
      if (!number || *number > PrintGrid::kMaxSide) return wrong_value(kMembers[member], "a number of pixels");
      (member == kX   ? request.window.column
       : member == kY ? request.window.row
                      : request.window.step) = static_cast<std::uint32_t>(*number);
      return {};
    }
    case kFrom: {
      const auto number = whole_number(value);
      if (!number) return wrong_value("from", "a number of bytes from 0 on");
      request.from = *number;
      return {};
    }
    case kPrint: {
      const auto number = whole_number(value);
      if (!number || *number == 0 || *number > UINT32_MAX) return wrong_value("print", "a number from 1 on");
      request.print = static_cast<std::uint32_t>(*number);
      return {};
    }
    case kProposal: {
      const auto number = whole_number(value);
      if (!number || *number >= kProposalCount) return wrong_value("proposal", "a number from 0 to 4");
      request.which = static_cast<std::uint32_t>(*number);
      return {};
    }
    case kFor:
    case kJob: {
      const auto id_named = value.kind == Value::Kind::kText ? id_of(value.text) : std::nullopt;
      if (!id_named) return wrong_value(kMembers[member], "an id of the state, 16 hexadecimal digits");
      (member == kFor ? request.about : request.job) = *id_named;
      return {};
    }
    case kName:
      request.name.add("%.*s", static_cast<int>(value.text.size()), value.text.data());
      if (value.kind != Value::Kind::kText || request.name.cut())
        return wrong_value("name", "a text of at most 79 bytes");
      return {};
    case kBytes: {
      const auto number = whole_number(value);
      if (!number) return wrong_value("bytes", "a whole number, 0 to 2^53");
      request.bytes = *number;
      return {};
    }
    case kMl: {
      const auto number = to_number<double>(value.text);
      if (value.kind != Value::Kind::kNumber || !number || !(*number >= 0))
        return wrong_value("ml", "a number from 0 on");
      request.ml = *number;
      return {};
    }
    case kCode:
      request.code.add("%.*s", static_cast<int>(value.text.size()), value.text.data());
      if (value.kind != Value::Kind::kText || request.code.cut() ||
          request.code.view().find_first_not_of("0123456789") != std::string_view::npos) {
        return wrong_value("code", "a text of up to 7 digits");
      }
      return {};
  }
  return {};
}

/// Whether a request has the members that its command needs, and no others.
Status check_members(const ClientRequest& request, const std::array<bool, kMembers.size()>& found) {
  if (!found[kDo])
    return fail(ErrorCode::kBadSetting, "there is no \"do\".\tSay what to do, such as {\"do\": \"pause\"}");
  std::uint32_t others = 0;
  for (std::size_t member = kScan; member < kMembers.size(); ++member) {
    if (found[member]) others |= bit(static_cast<RequestMember>(member));
  }
  if (request.command == Command::kPicture && found[kFrom] != (request.picture == PictureName::kPart)) {
    return fail(ErrorCode::kBadSetting,
                "the picture \"part\", and no other, needs \"from\", a number of bytes from 0 on");
  }
  if (request.command == Command::kPicture && found[kScan] != (request.picture == PictureName::kScan)) {
    return fail(ErrorCode::kBadSetting, "the picture \"scan\", and no other, needs \"scan\", a number from the list");
  }
  if (found[kProposal] && request.picture != PictureName::kProposal) {
    return fail(ErrorCode::kBadSetting, "\"proposal\" is for the picture \"proposal\" only");
  }
  Needs needs = needs_of(request.command);
  // Each command may say what it is meant for.
  if (static_cast<std::size_t>(request.command) < kCommandCount) needs.allowed |= bit(kFor);
  if ((others & ~needs.allowed) == needs.members) return {};
  const auto word = to_string(request.command);
  return fail(ErrorCode::kBadSetting, "%.*s needs %s beside \"do\" and \"id\"", static_cast<int>(word.size()),
              word.data(), needs.words);
}

}  // namespace

Expected<ClientRequest> parse_request(std::string_view line, std::optional<std::uint64_t>& id) {
  id.reset();
  ClientRequest request;
  std::array<bool, kMembers.size()> found{};
  std::array<char, 32> name_room;
  std::array<char, 900> value_room;
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
        return fail(ErrorCode::kBadSetting,
                    "'%.*s': unknown member.\tKnown are do, id, scan, key, value, picture, layer, from, code, "
                    "print, name, bytes, proposal, folder, ml, for, job, x, y and step",
                    static_cast<int>(name->size()), name->data());
      }
      const auto member = static_cast<RequestMember>(known - kMembers.begin());
      if (std::exchange(found[member], true)) return wrong_value(*name, "one");
      PLUMBLINE_TRY(store(member, *value, request, id));
    } while (cursor.take(','));
    if (!cursor.take('}')) return not_an_object();
  }
  if (!cursor.at_end()) return not_an_object();
  PLUMBLINE_TRY(check_members(request, found));
  return request;
}

Status write_request(TextSink& out, const ClientRequest& request, std::uint64_t id) {
  JsonWriter json(out);
  json.begin_object(JsonWriter::Layout::kOneLine);
  json.member("do", to_string(request.command));
  json.member("id", id);
  if (request.about != 0) json.member("for", id_text(request.about).view());
  if (request.command == Command::kChoose) json.member("scan", request.scan);
  if (request.command == Command::kOpen) json.member("folder", request.folder);
  if (request.command == Command::kUpload || request.command == Command::kRemove) {
    json.member("name", request.name.view());
  }
  if (request.command == Command::kUpload) json.member("bytes", request.bytes);
  if (request.ml) json.member("ml", *request.ml);
  if (request.command == Command::kSet) {
    json.member("key", request.key.view());
    json.member("value", request.value.view());
  }
  json.end_object();
  return json.finish();
}

}  // namespace plumbline::firmware::inline state
