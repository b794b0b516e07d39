#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "firmware/pictures/mask_window.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_line.hpp"

namespace plumbline::firmware::inline state {

/// A picture as it was drawn last.
struct DrawnPicture {
  std::span<const std::uint8_t> bytes;
  std::uint32_t columns = 0, rows = 0;
  std::uint32_t channels = 0;
  std::uint32_t number = 0;  ///< rises with each new one
};

/// @param which  of the sides, the proposals or the scans, from 0; 0 for other pictures
/// @returns none: there is no such picture now
std::optional<DrawnPicture> drawn_picture(const PrinterRecord& record, PictureName name, std::uint32_t which);

/// Writes pictures into replies: PNG in base64 (RFC 4648). Each picture is encoded once, however many clients ask for it; of the
/// sides, the proposals and the scans the last one.
class PictureLine {
 public:
  /// Takes all its memory here.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<PictureLine> create();

  /// @param id    the request's; none: it had none
  /// @param which  of the sides, the proposals or the scans, from 0; 0 for other pictures
  /// @retval ErrorCode::kBadSetting   there is no such picture now
  /// @retval ErrorCode::kCannotWrite  it is too large for a line
  [[nodiscard]] Status write(TextSink& out, std::optional<std::uint64_t> id, PictureName name, std::uint32_t which,
                             const PrinterRecord& record);

  /// Room for the picture of a mask that somebody asks for.
  MaskPicture& mask() { return *mask_; }
  /// @param layer  of mask()
  /// @param job    PrinterRecord::job_id
  /// @retval ErrorCode::kCannotWrite  it is too large for a line
  [[nodiscard]] Status write_mask(TextSink& out, std::optional<std::uint64_t> id, std::uint32_t layer,
                                  std::uint64_t job);

  /// The preview of a print that is kept.
  /// @retval ErrorCode::kBadSetting   no such print is kept, or it has none
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] Status write_kept(TextSink& out, std::optional<std::uint64_t> id, const KeptPrints& prints,
                                  std::uint32_t print);

  /// Of a PNG: more don't fit into a line.
  static constexpr std::size_t kMostPng = (kLongestLine - 256) / 4 * 3;

 private:
  /// A picture as it was encoded last.
  struct Encoded {
    std::uint32_t number = 0;  ///< 0: none
    std::uint32_t which = 0;
    std::vector<char> base64;
    std::size_t size = 0;
  };
  explicit PictureLine(PictureEncoder encoder) : encoder_(std::move(encoder)) {}

  PictureEncoder encoder_;
  std::unique_ptr<MaskPicture> mask_ = std::make_unique<MaskPicture>();
  std::vector<char> mask_base64_;
  std::array<Encoded, kPictureWords.size()> encoded_;
};

}  // namespace plumbline::firmware::inline state
