#include "firmware/machine/back_end.hpp"

#include "firmware/machine/linux_back_end.hpp"
#include "firmware/machine/simulated_back_end.hpp"

namespace plumbline::firmware {

Status check_back_end(const BoardFile& board, const MachineFile& machine, const SimulationOptions& options) {
  if (!machine.simulated && !options.simulate) return check_linux_back_end(board, machine);
  if (!options.lamp_line.empty() && options.speedup <= 0) {
    return fail(ErrorCode::kBadSetting,
                "--lamp-line lights a real line, which needs real time: add --realtime or --speedup N");
  }
  return check_simulated_back_end(options);
}

Expected<std::unique_ptr<BackEnd>> open_back_end(const BoardFile& board, const MachineFile& machine,
                                                 const PrintProfile& profile, const SimulationOptions& options) {
  PLUMBLINE_TRY(check_back_end(board, machine, options));
  if (!machine.simulated && !options.simulate) return open_linux_back_end(board, machine);
  std::unique_ptr<KeptLampLine> lamp_line;
  if (!options.lamp_line.empty()) {
    auto line = keep_lamp_line(options.lamp_line, machine);
    PLUMBLINE_TRY(line);
    lamp_line = std::move(*line);
  }
  return open_simulated_back_end(board, machine, profile, options, std::move(lamp_line));
}

Expected<std::vector<MachineFinding>> examine_machine(const BoardFile& board, const MachineFile& machine) {
  if (machine.simulated) {
    return fail(ErrorCode::kUnsupported,
                "printer %s is a simulated one (its board file says simulated = true), so it has no hardware to check",
                board.name.c_str());
  }
  return examine_linux_machine(board, machine);
}

std::vector<BoardPart> board_parts() { return linux_board_parts(); }

}  // namespace plumbline::firmware
