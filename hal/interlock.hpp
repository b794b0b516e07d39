#pragma once
/// What each device checks about the others before it acts.

#include "slicer/core/error.hpp"

namespace plumbline::inline hal {

class FrontPanel;
class MaskDisplay;
class UvLamp;
class ZStage;

/// Connects the devices of one machine, so that the base classes can refuse what would harm a print or its user, once for every
/// back end. Made before the devices; each adds itself in its constructor.
///
///   light       needs a mask on the panel, the cover closed and the stage at rest
///   a new mask  needs the lamp off
///   motion      needs the lamp off
class Interlock {
 public:
  Interlock() = default;
  Interlock(const Interlock&) = delete;
  Interlock& operator=(const Interlock&) = delete;

  /// The back end calls this when the supply fails. From then on every device call returns kPowerLost.
  void lose_power() { powered_ = false; }
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status check_power() const;

  bool lamp_lit() const;        ///< UvLamp::lit()
  bool stage_moving() const;    ///< ZStage::moving()
  bool mask_presented() const;  ///< MaskDisplay::presented()
  bool cover_open() const;      ///< FrontPanel::cover_open()

  void add(const UvLamp& lamp) { lamp_ = &lamp; }
  void add(const ZStage& stage) { stage_ = &stage; }
  void add(const MaskDisplay& mask) { mask_ = &mask; }
  void add(const FrontPanel& panel) { panel_ = &panel; }

 private:
  bool powered_ = true;
  const UvLamp* lamp_ = nullptr;
  const ZStage* stage_ = nullptr;
  const MaskDisplay* mask_ = nullptr;
  const FrontPanel* panel_ = nullptr;
};

}  // namespace plumbline::inline hal
