#pragma once
/// The LCD panel that lets the light through where the resin is to cure.

#include <cstdint>
#include <utility>

#include "hal/interlock.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

class MaskDisplay;

/// A mask that may be written: lent by the display, given back by presenting it or by letting it go. Move-only; a mask that is
/// on the panel has no MaskBuffer.
class MaskBuffer {
 public:
  MaskBuffer(MaskBuffer&& other) noexcept
      : display_(std::exchange(other.display_, nullptr)), image_(std::exchange(other.image_, BitImage())) {}
  MaskBuffer& operator=(MaskBuffer&& other) noexcept;
  MaskBuffer(const MaskBuffer&) = delete;
  MaskBuffer& operator=(const MaskBuffer&) = delete;
  ~MaskBuffer() { give_back(); }

  /// Print coordinates, as PrintGrid has them: one bit a pixel, one lets light through. Its content is what a former mask
  /// left: write every word. Empty (no columns) after the buffer was presented or moved from.
  BitImage image() const { return image_; }

 private:
  friend class MaskDisplay;
  MaskBuffer(MaskDisplay& display, BitImage image) : display_(&display), image_(image) {}
  void give_back();

  MaskDisplay* display_ = nullptr;
  BitImage image_;
};

/// The panel, with two buffers: one on the panel, one to write. How pixels are packed, mirrored and rotated is the back end's,
/// from the board file.
class MaskDisplay {
 public:
  MaskDisplay(const MaskDisplay&) = delete;
  MaskDisplay& operator=(const MaskDisplay&) = delete;
  virtual ~MaskDisplay() = default;

  std::uint32_t columns() const { return columns_; }  ///< pixels along x
  std::uint32_t rows() const { return rows_; }        ///< pixels along y

  /// Lends the buffer that is not on the panel. It can be written while the lamp shines through the other.
  /// @retval ErrorCode::kBusy       it has been lent already and is not back
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<MaskBuffer> lend();

  /// Shows a mask. Returns when the panel has it, all rows of it, settled: after the flip and the scan-out, within a bound that
  /// the board file sets.
  /// @param buffer  empty after it; where the call was refused (kLampLit) still the caller's
  /// @retval ErrorCode::kLampLit      a mask must not change under light
  /// @retval ErrorCode::kFlipTimeout  the panel did not take it in time. What it shows is unknown, presented() is false
  /// @retval ErrorCode::kPanelFailed  the panel does not answer
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status present(MaskBuffer&& buffer);

  /// Shows black. Returns as present() does.
  /// @retval ErrorCode::kLampLit, kFlipTimeout, kPanelFailed, kPowerLost
  [[nodiscard]] Status blank();

  /// A mask has been scanned out, and nothing else since.
  bool presented() const { return presented_; }

 protected:
  MaskDisplay(std::uint32_t columns, std::uint32_t rows, Interlock& interlock)
      : columns_(columns), rows_(rows), interlock_(interlock) {
    interlock.enter(*this);
  }

 private:
  friend class MaskBuffer;

  /// @returns columns() x rows(), valid until do_present() or do_give_back()
  virtual Expected<BitImage> do_lend() = 0;
  virtual void do_give_back() = 0;
  /// Puts the lent buffer on the panel. The other one is free afterwards.
  virtual Status do_present() = 0;
  virtual Status do_blank() = 0;

  std::uint32_t columns_;
  std::uint32_t rows_;
  Interlock& interlock_;
  bool lent_ = false;
  bool presented_ = false;
};

}  // namespace plumbline
