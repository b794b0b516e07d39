#pragma once
/// What the printer knows at rest of where it stands: its temperatures, and what a browser reaches its page by.

#include <optional>

#include "firmware/print/job/machine_record.hpp"
#include "firmware/settings/board_file.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/machine.hpp"

namespace plumbline::firmware {

class Surroundings {
 public:
  /// Between two looks: a sensor's reading may be 2 s old, and a cable is plugged in more slowly.
  static constexpr nanoseconds kTurn = std::chrono::seconds(5);

  /// All must outlive it. Looks for the first time.
  /// @param settings        the page's
  /// @param machine_record  gets the temperatures
  Surroundings(Machine& machine, const MachineFile& settings, MachineRecord& machine_record, PrinterRecord& record);

  /// Looks again, if the last look is kTurn ago. Called while nothing is printed.
  void look();

 private:
  Machine& machine_;
  const MachineFile& settings_;
  MachineRecord& machine_record_;
  PrinterRecord& record_;
  std::optional<TimePoint> looked_at_;
};

}  // namespace plumbline::firmware
