#pragma once
/// Memory of a display card that can be drawn in and scanned out.

#include <cstddef>
#include <cstdint>
#include <span>

#include "slicer/core/error.hpp"

namespace plumbline::inline hal::inline linux_board::kms {

/// A "dumb buffer" of XRGB8888 or RGB565, mapped for good and black at first. Move-only; its card must stay open.
class Buffer {
 public:
  /// @param card  descriptor of an open card
  /// @param bits  of a pixel: 16 is RGB565, everything else XRGB8888
  /// @retval ErrorCode::kPanelFailed  the driver refused: the reason
  [[nodiscard]] static Expected<Buffer> create(int card, std::uint32_t width, std::uint32_t height,
                                               std::uint32_t bits = 24);
  Buffer() = default;
  Buffer(Buffer&& other) noexcept { *this = std::move(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    std::swap(data_, other.data_);
    return *this;
  }
  ~Buffer();

  std::uint32_t frame() const { return data_.frame; }               ///< object number for the driver
  std::span<std::uint32_t> pixels() const { return data_.pixels; }  ///< all of its memory
  std::size_t pitch() const { return data_.pitch; }                 ///< words a row

 private:
  struct Data {
    int card = -1;
    std::uint32_t handle = 0;
    std::uint32_t frame = 0;
    std::size_t pitch = 0;
    std::span<std::uint32_t> pixels;
  } data_;
};

}  // namespace plumbline::inline hal::inline linux_board::kms
