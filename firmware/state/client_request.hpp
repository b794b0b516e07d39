#pragma once
/// What a client of the state socket asks for: one JSON object a line, flat, with a few known members.
///
///     {"do": "start"}   {"do": "choose", "scan": 2, "id": 7}   {"do": "set", "key": "scale", "value": 1.5}
///     {"do": "picture", "picture": "layer"}   {"do": "mask", "layer": 12}   {"do": "mask", "layer": 12, "x": 640, "y": 1200, "step": 1}   {"do": "report", "from": 24576}   {"do": "code", "code": "482913"}
///     {"do": "upload", "name": "bust.ply", "bytes": 480213}   {"do": "remove", "name": "bust.ply"}
///     {"do": "report", "print": 12, "from": 0}   {"do": "picture", "picture": "preview", "print": 12}
///     {"do": "picture", "picture": "part", "from": 0}   {"do": "picture", "picture": "proposal", "proposal": 1}   {"do": "propose"}
///     {"do": "picture", "picture": "scan", "scan": 2}   {"do": "open", "folder": 1}
///     {"do": "filled"}   {"do": "filled", "ml": 120}   {"do": "settings"}
///     {"do": "start", "for": "9f3c01d2a4b5e687"}   {"do": "mask", "layer": 12, "job": "1b0f..."}
///
/// Takes nothing from the heap, whatever the line.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/io/text/text_sink.hpp"
#include "firmware/pictures/mask_window.hpp"
#include "firmware/state/command_rules.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline state {

enum class PictureName : std::uint8_t { kPreview, kIssues, kLayer, kPart, kProposal, kScan };
/// In this order.
inline constexpr std::array<std::string_view, 6> kPictureWords = {"preview", "issues",   "layer",
                                                                  "part",    "proposal", "scan"};

struct ClientRequest {
  Command command = Command::kStart;
  std::uint64_t about = 0;   ///< "for": the question or the job that a command is meant for; 0: it does not say
  std::uint64_t job = 0;     ///< of picture, mask and report: whose it must be; 0: that of the job at hand
  std::uint32_t scan = 0;    ///< of choose, and of picture if it is that of a scan: from 1
  std::uint32_t folder = 0;  ///< of open: from 1; 0: the one above
  PictureName picture = PictureName::kPreview;
  std::uint32_t which = 0;   ///< of picture, if it is that of a proposal: from 0
  std::uint32_t layer = 0;   ///< of mask: from 0
  MaskWindow window;         ///< of mask
  std::uint64_t from = 0;    ///< of report, and of picture if it is the part: the first byte
  std::uint32_t print = 0;   ///< of report and picture: a print that is kept, from 1; 0: the last one, the job at hand
  FixedText<80> name;        ///< of upload and remove: as it was sent, so anything
  std::uint64_t bytes = 0;   ///< of upload: that will come
  std::optional<double> ml;  ///< of filled: resin in the tank, 0 or more; none: it is full
  FixedText<8> code;         ///< of code: digits; empty: show none any more
  FixedText<32> key;         ///< of set
  FixedText<900> value;      ///< of set: a text, or a number, true or false as it is written
};

/// The longest request line, bytes, without its end.
inline constexpr std::size_t kLongestRequest = 1023;

/// @param line  without its end
/// @param id    set to the request's number, also if the request is refused behind it; none: it has none
/// @retval ErrorCode::kMalformed   not a flat JSON object of texts, numbers, true and false
/// @retval ErrorCode::kBadSetting  an unknown command or member; a member that the command needs or does not know
[[nodiscard]] Expected<ClientRequest> parse_request(std::string_view line, std::optional<std::uint64_t>& id);

/// Writes a command, with its end.
/// @retval ErrorCode::kCannotWrite  `out` is full
[[nodiscard]] Status write_request(TextSink& out, const ClientRequest& request, std::uint64_t id);

}  // namespace plumbline::firmware::inline state
