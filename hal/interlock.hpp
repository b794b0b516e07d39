#pragma once
/// What one device must know of the others before it does anything.

#include "slicer/core/error.hpp"

namespace plumbline {

class FrontPanel;
class MaskDisplay;
class UvLamp;
class ZStage;

/// Introduces the devices of one machine to each other, so that the refusals that keep a print and its user safe are in the
/// bases, once, for every back end. Made first; each device enters itself when it is constructed and lives as long.
///
///   light needs     a mask on the panel, the cover closed, the stage at rest
///   a new mask      needs darkness
///   motion          needs darkness
class Interlock {
 public:
  Interlock() = default;
  Interlock(const Interlock&) = delete;
  Interlock& operator=(const Interlock&) = delete;

  /// Called by the back end when the supply fails: from then on every call of every device says so.
  void lose_power() { powered_ = false; }
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status power() const;

  bool lamp_lit() const;        ///< UvLamp::lit()
  bool stage_moving() const;    ///< ZStage::moving()
  bool mask_presented() const;  ///< MaskDisplay::presented()
  bool cover_open() const;      ///< FrontPanel::cover_open()

  void enter(const UvLamp& lamp) { lamp_ = &lamp; }
  void enter(const ZStage& stage) { stage_ = &stage; }
  void enter(const MaskDisplay& mask) { mask_ = &mask; }
  void enter(const FrontPanel& panel) { panel_ = &panel; }

 private:
  bool powered_ = true;
  const UvLamp* lamp_ = nullptr;
  const ZStage* stage_ = nullptr;
  const MaskDisplay* mask_ = nullptr;
  const FrontPanel* panel_ = nullptr;
};

}  // namespace plumbline
