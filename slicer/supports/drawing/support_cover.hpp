#pragma once
/// What a layer's supports cover, apart from its mask.

#include <cstdint>

#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/supports/drawing/support_painter.hpp"

namespace plumbline::inline slicer {

class SupportCover {
 public:
  /// @param supports  must outlive this; if there are none, it takes nothing and covers nothing
  /// @retval ErrorCode::kOutOfMemory  no room for bytes_needed() at the bottom of the arena
  [[nodiscard]] static Expected<SupportCover> create(const PrintGrid& grid, const Supports& supports, Arena& arena);
  static std::size_t bytes_needed(const PrintGrid& grid, std::size_t supports);

  void draw(std::uint32_t layer);
  void clear();  ///< what was drawn
  bool at(std::uint32_t column, std::uint32_t row) const { return exists_ && image_.at(column, row); }
  std::uint64_t word(std::uint32_t row, std::uint32_t word) const { return exists_ ? image_.row(row)[word] : 0; }

 private:
  bool exists_ = false;
  SupportPainter painter_;
  BitImage image_;
  BitImage drawn_;  ///< as SupportPainter::draw() says
};

}  // namespace plumbline::inline slicer
