#pragma once

#include "firmware/daemon/stick/scan_slicing.hpp"
#include "firmware/print/print_session.hpp"
#include "firmware/print/status/print_observer.hpp"
#include "firmware/settings/print_profile.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware {

/// Follows the daemon: a log, the state socket, or a test.
class DaemonObserver : public PrintObserver, public SlicingObserver {
 public:
  /// "ready", "reading bust.ply", ...
  virtual void say(const PrintableText& text) = 0;
  /// Called before a print begins or goes on, with what it will do.
  virtual void begins(const Contract& contract) = 0;
  /// Called when a print has ended, for any reason.
  virtual void printed(const PrintReport& report, const PrintSession& session, const PrintProfile& profile) = 0;
  /// Somebody has taken off what was on the plate.
  virtual void plate_emptied() {}
  /// Called several times a second while nothing is printed.
  virtual void idle() = 0;
};

}  // namespace plumbline::firmware
