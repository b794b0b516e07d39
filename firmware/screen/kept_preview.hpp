#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/pictures/job_pictures.hpp"
#include "firmware/pictures/png.hpp"
#include "firmware/print/job/kept_prints.hpp"

namespace plumbline::firmware::inline screen {

/// The preview of the kept print that somebody looks at: read and decoded once, when another one is asked for.
class KeptPreview {
 public:
  /// Takes all its memory here.
  /// @retval ErrorCode::kOutOfMemory
  [[nodiscard]] static Expected<KeptPreview> create();

  /// @param number  of a print
  /// @returns its preview, valid until the next call; nullptr: it has none, or none that can be read
  const PreviewPicture* of(const KeptPrints& prints, std::uint32_t number);

 private:
  explicit KeptPreview(PictureDecoder decoder);

  PictureDecoder decoder_;
  std::vector<std::byte> file_;
  std::vector<PreviewPicture> picture_;  ///< one: too large for a stack
  std::uint32_t number_ = 0;             ///< of the picture; 0: none
};

}  // namespace plumbline::firmware::inline screen
