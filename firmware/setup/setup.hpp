#pragma once
/// `plumbline setup`: from questions and measurements to a board file.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "firmware/machine/back_end.hpp"
#include "firmware/setup/board_draft.hpp"
#include "firmware/setup/dialogue.hpp"

namespace plumbline::firmware {

/// Longest light for a look at the panel, and for a meter's reading.
inline constexpr std::chrono::seconds kFlash{1};
inline constexpr std::chrono::seconds kMeterFlash{5};
/// Longest light for a cured sheet, s.
inline constexpr double kLongestSheetS = 30;

/// Opens the devices of a draft. Each measurement opens them anew, and closes them at its end: the lamp is dark and the stage still
/// whenever nothing is measured.
using OpenMachine = std::function<Expected<std::unique_ptr<BackEnd>>(const BoardFile& board)>;

/// A line for each part: its kind, its name as an answer takes it, what else is known.
std::string to_text(std::span<const BoardPart> parts);

/// Asks for everything that nobody can measure. A simulated printer has no wiring.
/// @retval ErrorCode::kCancelled, kBadSetting  as Dialogue::ask()
[[nodiscard]] Status ask_about_printer(Dialogue& dialogue, BoardDraft& draft, const std::string& name);

/// Shows a picture and asks what somebody sees: rotation, mirror, and which side of the panel is x.
/// @retval ErrorCode::kCancelled, ...  as Dialogue::ask() and the devices
[[nodiscard]] Status measure_panel(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open);

/// Jogs the stage and asks how far it went: steps a mm, and which way is up.
[[nodiscard]] Status measure_stage(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open);

/// Finds the lamp's irradiance with a meter or by the thickness of a cured sheet.
/// @param profile  of the resin that is cured
[[nodiscard]] Status measure_lamp(Dialogue& dialogue, BoardDraft& draft, const OpenMachine& open,
                                  const PrintProfile& profile);

/// Irradiance that cures `thickness_mm` in `lit`: P = Ec exp(Cd / Dp) / t, from Jacobs' working curve Cd = Dp ln(P t / Ec).
/// @param thickness_mm  Cd, above 0
Irradiance irradiance_of(const PrintProfile& resin, double thickness_mm, std::chrono::duration<double> lit);

}  // namespace plumbline::firmware
