#pragma once
/// The checks before a print.

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/print/loop/print_settings.hpp"
#include "firmware/print/status/fault.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "firmware/print/status/print_report.hpp"
#include "hal/machine.hpp"
#include "slicer/core/print_grid.hpp"

namespace plumbline::firmware {

class PrintChecks {
 public:
  /// @param results  of all checks; the observer is notified of each. All must outlive this
  PrintChecks(Machine& machine, const PrintSettings& settings, std::array<CheckResult, kCheckCount>& results,
              PrintObserver& observer)
      : machine_(machine), settings_(settings), results_(results), observer_(observer) {}

  /// Runs all checks but that of the stage, so that the user learns everything that is wrong at once. Nothing moves or lights.
  /// @param masks         the grid of the print's masks
  /// @param cured_pixels  before this run
  /// @param left_ml       resin in the tank; none: unknown
  /// @retval ErrorCode::kPowerLost
  [[nodiscard]] Status run(const PrintGrid& masks, std::uint64_t cured_pixels, std::optional<double> left_ml,
                           bool has_journal);

  /// The homing at the start of the print checks the stage.
  void stage_homed();
  /// @param doubt  what that homing found instead of what the journal says
  void journal_in_doubt(const Spoken& doubt);
  void stage_failed(const Error& error);

  /// Fault of the first check that failed; kNone: none did.
  FaultCode fault() const { return fault_; }
  const CheckResult& failed() const { return result(failed_); }

 private:
  void check_job(bool has_journal);
  void check_resin(std::uint64_t cured_pixels, std::optional<double> left_ml);
  [[nodiscard]] Status check_panel(const PrintGrid& masks);
  void check_lamp_dark();
  void check_cover();
  [[nodiscard]] Status check_temperatures();
  CheckResult& result(Check check) { return results_[static_cast<std::size_t>(check)]; }
  const CheckResult& result(Check check) const { return results_[static_cast<std::size_t>(check)]; }
  void conclude_failed(Check check, const Error& error);
  /// @param code  the fault if the outcome is kFailed
  void conclude(Check check, CheckOutcome outcome, FaultCode code = FaultCode::kNone);

  Machine& machine_;
  const PrintSettings& settings_;
  std::array<CheckResult, kCheckCount>& results_;
  PrintObserver& observer_;
  FaultCode fault_ = FaultCode::kNone;
  Check failed_ = Check::kMemory;
};

}  // namespace plumbline::firmware
