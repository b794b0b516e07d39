#pragma once
/// The machine that a board file describes, opened. back_end.cpp is the one file of the product that knows the back ends.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/print/print_report.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "hal/machine.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// How a machine is to be simulated.
struct SimulationOptions {
  bool simulate = false;  ///< also a printer that is not
  double speedup = 0;     ///< virtual seconds a second: 1 is real time; 0: as fast as the host can
  double computing = 1;   ///< virtual seconds that a second of the host's work takes; 0: none, and each run is the same
  std::vector<std::string> faults;  ///< "lamp.stuck_on@layer=40": hal/sim/README.md
  std::string stick;                ///< folder that plays the stick; empty: none
  bool keep_part = false;
  std::string lamp_line;  ///< that plumbline-keeper holds and lights as the simulated lamp is lit; empty: none
};

/// What only a simulation knows.
class Witness {
 public:
  virtual ~Witness() = default;
  /// The print is over: the last layer is judged.
  virtual void conclude(bool finished) = 0;
  /// What would have ruined the print or hurt someone, with time and place.
  virtual std::vector<std::string> objections() const = 0;
  /// Layers of the part, from the plate on. Needs SimulationOptions::keep_part.
  virtual void for_each_cured_layer(const std::function<void(ZPosition, ConstBitImage)>& visit) const = 0;

  /// The user's hands, for who plays the user.
  virtual void plug_stick(const std::string& folder) = 0;
  virtual void pull_stick() = 0;
  virtual void press(EventKind button) = 0;
};

/// Owns the devices.
class BackEnd {
 public:
  virtual ~BackEnd() = default;
  virtual Machine& machine() = 0;
  /// @returns null on a board
  virtual Witness* witness() = 0;
  /// How well the stage kept its times since this was last asked; none in simulation. @pre the stage stands
  virtual std::optional<StepFigures> take_step_figures() = 0;
};

/// Opens all devices.
/// @param profile  its resin is what the simulated vat holds
/// @retval ErrorCode::kBadSetting   a fault that is none, or a lamp's line without a speedup
/// @retval ErrorCode::kLampFailed   the lamp's keeper could not be started
/// @retval ErrorCode::kUnsupported  this build has no back end for the printer
/// @retval ErrorCode::kBadSetting, kCannotOpen, ...  of a board's devices: which one, what was found, what to do
[[nodiscard]] Expected<std::unique_ptr<BackEnd>> open_back_end(const BoardFile& board, const MachineFile& machine,
                                                               const PrintProfile& profile,
                                                               const SimulationOptions& options);

/// What a look at this board found of one device or right that the printer needs.
struct MachineFinding {
  enum class Verdict : std::uint8_t {
    kGood,
    kPoor,   ///< it prints, but not as well as it could
    kWrong,  ///< it does not print
  } verdict = Verdict::kGood;
  std::string what;
  std::string found;
  std::string advice;  ///< what to do; empty: nothing
};

/// Looks at the board that this runs on. Moves and lights nothing.
/// @retval ErrorCode::kUnsupported  the printer is a simulated one, or this build drives no others
[[nodiscard]] Expected<std::vector<MachineFinding>> examine_machine(const BoardFile& board, const MachineFile& machine);

}  // namespace plumbline
