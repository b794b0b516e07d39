#pragma once
/// The back end over hal/sim. simulated_back_end.cpp is the one file of the product that includes it.

#include <memory>

#include "firmware/machine/back_end.hpp"
#include "firmware/machine/kept_lamp_line.hpp"

namespace plumbline::firmware {

/// @retval ErrorCode::kBadSetting  one of options.faults is not a fault
[[nodiscard]] Status check_simulated_back_end(const SimulationOptions& options);

/// @param lamp_line  lit while the simulated lamp is lit, in the host's time; null: none. Needs options.speedup above 0
/// @retval ErrorCode::kBadSetting  one of options.faults is not a fault
[[nodiscard]] Expected<std::unique_ptr<BackEnd>> open_simulated_back_end(const BoardFile& board,
                                                                         const MachineFile& machine,
                                                                         const PrintProfile& profile,
                                                                         const SimulationOptions& options,
                                                                         std::unique_ptr<KeptLampLine> lamp_line);

}  // namespace plumbline::firmware
