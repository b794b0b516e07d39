#pragma once
/// Opens the machine that a board file describes: the simulated one or the Linux board this runs on.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/machine/part_figures.hpp"
#include "firmware/machine/step_figures.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/settings/print_profile.hpp"
#include "hal/board_part.hpp"
#include "hal/machine.hpp"
#include "hal/machine_finding.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

/// How to simulate a machine.
struct SimulationOptions {
  bool simulate = false;  ///< simulate even a real printer
  double speedup = 0;     ///< virtual seconds per second; 1: real time, 0: as fast as the host can
  double computing = 1;   ///< virtual seconds per second of the host's work; 0: none, and every run is the same
  std::vector<std::string> faults;  ///< "lamp.stuck_on@layer=40": hal/sim/README.md
  std::string stick;                ///< folder that plays the stick; empty: none
  bool keep_part = false;
  std::string screen;                 ///< folder into which its status screen writes what it shows; empty: none
  std::uint32_t layers_on_plate = 0;  ///< cured by an earlier run that this one resumes
  ZPosition height_on_plate;          ///< of the last of them
  std::optional<ZPosition> plate_at;  ///< where that run left the plate; nothing: raised
  /// How the simulated printer is built where the board file is wrong about it: `plumbline setup` measures it. Must have a machine.
  std::optional<BoardFile> built;
  std::string lamp_line;  ///< plumbline-keeper lights it whenever the simulated lamp is lit; empty: none
};

/// A picture that somebody sees.
struct Sight {
  std::uint32_t columns = 0, rows = 0;
  std::vector<std::uint64_t> words;

  ConstBitImage image() const { return {words, columns, rows}; }
};

/// What only a simulation knows, and the actions of a simulated user.
class Witness {
 public:
  virtual ~Witness() = default;
  /// Ends the print and judges its last layer.
  virtual void conclude(bool finished) = 0;
  /// What would have ruined the print or hurt someone, with time and place.
  virtual std::vector<std::string> objections() const = 0;
  /// The part, since the machine was opened.
  virtual PartFigures part_figures() const = 0;
  /// Layers of the part, from the plate on: the pixels of the masks that were cured and stayed. Needs SimulationOptions::keep_part.
  virtual void for_each_cured_layer(const std::function<void(ZPosition, ConstBitImage)>& visit) const = 0;

  /// Where the cured part ends on the line through each point along its normal, as DoseField has it: mm outwards. Not finite if it does not
  /// within 0.6 mm: infinity where all is cured, -infinity where nothing is. Needs SimulationOptions::keep_part.
  /// @param truth  points of the true surface, print coordinates, mm
  virtual std::vector<float> deviations_mm(std::span<const OrientedPoint> truth) const = 0;

  /// The panel's pixels that let light through, for somebody who looks down on it with its lower edge in front.
  virtual Sight panel_from_above() = 0;
  virtual Distance plate_height() = 0;  ///< above the film
  virtual Irradiance irradiance() = 0;  ///< that a meter on the film reads under a white mask
  virtual bool light() = 0;

  /// The person who says that the plate is empty has taken the part off.
  virtual void take_part_off() = 0;
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
  /// How well the Z stage kept its times since the last call; none in simulation. @pre the stage is at rest
  virtual std::optional<StepFigures> take_step_figures() = 0;
};

/// Checks what open_back_end() would refuse without looking at a device, so that it can be said before a scan is sliced.
/// @retval ErrorCode::kBadSetting, kUnsupported  as open_back_end()
[[nodiscard]] Status check_back_end(const BoardFile& board, const MachineFile& machine,
                                    const SimulationOptions& options);

/// Opens all devices.
/// @param profile  its resin fills the simulated vat
/// @retval ErrorCode::kBadSetting   an unknown fault, a lamp line without a speedup, or missing wiring tables
/// @retval ErrorCode::kLampFailed   the lamp's keeper could not be started
/// @retval ErrorCode::kUnsupported  this build has no back end for the printer
/// @retval ErrorCode::kCannotOpen, ...  of one device: the message names it, what was found, what to do
[[nodiscard]] Expected<std::unique_ptr<BackEnd>> open_back_end(const BoardFile& board, const MachineFile& machine,
                                                               const PrintProfile& profile,
                                                               const SimulationOptions& options);

/// Checks the board that this runs on. Moves and lights nothing.
/// @retval ErrorCode::kUnsupported  the printer is a simulated one, or this build has no board devices
[[nodiscard]] Expected<std::vector<MachineFinding>> examine_machine(const BoardFile& board, const MachineFile& machine);

/// What the board that this runs on has for a board file to name. Opens, moves and lights nothing.
std::vector<BoardPart> board_parts();

}  // namespace plumbline::firmware
