#pragma once
/// Writes down what the daemon does, for the state socket.

#include "firmware/daemon/daemon_observer.hpp"
#include "firmware/state/printer_record.hpp"
#include "hal/stick_port.hpp"

namespace plumbline {

/// Stands between the daemon and its observer.
class StateRecorder final : public DaemonObserver {
 public:
  /// All must outlive it.
  StateRecorder(PrinterRecord& record, const StickPort& stick, DaemonObserver& observer)
      : record_(record), stick_(stick), observer_(observer) {}

  void say(const PrintableText& text) override;
  bool update(const PrintStatus& status) override;
  void checked(Check check, const CheckResult& result) override;
  void slicing(Stage stage, double fraction) override;
  void printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) override;
  void idle() override;

 private:
  void look_at_stick();

  PrinterRecord& record_;
  const StickPort& stick_;
  DaemonObserver& observer_;
};

}  // namespace plumbline
