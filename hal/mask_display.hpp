#pragma once
/// The LCD panel that lets light through where resin is to cure.

#include <cassert>
#include <cstdint>
#include <utility>

#include "hal/interlock.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal {

class MaskDisplay;

/// A writable mask, lent by the display until it is presented or destroyed. Move-only. A mask that is on the panel has no
/// MaskBuffer, so nobody can write it.
class MaskBuffer {
 public:
  MaskBuffer(MaskBuffer&& other) noexcept
      : display_(std::exchange(other.display_, nullptr)),
        image_(std::exchange(other.image_, BitImage())),
        greys_(std::exchange(other.greys_, nullptr)) {}
  MaskBuffer& operator=(MaskBuffer&& other) noexcept;
  MaskBuffer(const MaskBuffer&) = delete;
  MaskBuffer& operator=(const MaskBuffer&) = delete;
  ~MaskBuffer() { release(); }

  /// One bit a pixel in PrintGrid coordinates; 1 lets light through. It holds an older mask, so write every word. Empty (no
  /// columns) once the buffer was presented or moved from.
  BitImage image() const { return image_; }
  /// Pixels that let some of the light through, whatever their bits say. Empty when the buffer is lent; without room if the panel shows
  /// black and white only. To be finished when it is presented. @pre the buffer is lent
  GreyRuns& greys() const {
    assert(greys_ != nullptr);
    return *greys_;
  }

 private:
  friend class MaskDisplay;
  MaskBuffer(MaskDisplay& display, BitImage image, GreyRuns& greys)
      : display_(&display), image_(image), greys_(&greys) {}
  void release();

  MaskDisplay* display_ = nullptr;
  BitImage image_;
  GreyRuns* greys_ = nullptr;
};

/// The panel, with two buffers: one shown, one to write. The back end packs, mirrors and rotates pixels as the board file says.
class MaskDisplay {
 public:
  MaskDisplay(const MaskDisplay&) = delete;
  MaskDisplay& operator=(const MaskDisplay&) = delete;
  virtual ~MaskDisplay() = default;

  std::uint32_t columns() const { return columns_; }  ///< pixels along x
  std::uint32_t rows() const { return rows_; }        ///< pixels along y

  /// Lends the buffer that is not on the panel. It may be written while the lamp shines through the other one.
  /// @retval ErrorCode::kBusy       it is still lent
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Expected<MaskBuffer> lend();

  /// Shows a mask. Returns when the flip and the scan-out are over and all rows have settled, or when the board file's time limit
  /// has passed.
  /// @param buffer  empty afterwards; still the caller's if the call was refused (kLampLit, kPowerLost)
  /// @retval ErrorCode::kLampLit      a mask must not change under light
  /// @retval ErrorCode::kFlipTimeout  the flip took too long. What the panel shows is unknown; presented() is false
  /// @retval ErrorCode::kPanelFailed  the panel does not answer
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status present(MaskBuffer&& buffer);

  /// Shows black, and returns like present().
  /// @retval ErrorCode::kLampLit, kFlipTimeout, kPanelFailed, kPowerLost
  [[nodiscard]] Status blank();

  /// Whether the panel shows the mask that was presented last.
  bool presented() const { return presented_; }

 protected:
  MaskDisplay(std::uint32_t columns, std::uint32_t rows, Interlock& interlock)
      : columns_(columns), rows_(rows), interlock_(interlock) {
    interlock.add(*this);
  }

  struct Lent {
    BitImage image;   ///< columns() x rows() pixels
    GreyRuns* greys;  ///< not null
  };

 private:
  friend class MaskBuffer;

  /// @returns what is valid until do_present() or do_release()
  virtual Expected<Lent> do_lend() = 0;
  virtual void do_release() = 0;
  /// Puts the lent buffer on the panel. The other one can be lent afterwards.
  virtual Status do_present() = 0;
  virtual Status do_blank() = 0;

  std::uint32_t columns_;
  std::uint32_t rows_;
  Interlock& interlock_;
  bool lent_ = false;
  bool presented_ = false;
};

}  // namespace plumbline::inline hal
