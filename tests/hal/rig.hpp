#pragma once
/// A machine under test and a tester who operates and observes it.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/machine.hpp"

namespace plumbline {

class Rig {
 public:
  Rig() = default;
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  virtual ~Rig() = default;

  virtual Machine machine() = 0;

  // The tester's hands. Each acts `after` from now, even while the machine works.
  virtual void open_cover(nanoseconds after) = 0;
  virtual void close_cover(nanoseconds after) = 0;
  virtual void press(EventKind button, nanoseconds after) = 0;
  virtual void plug_stick(const std::string& folder, nanoseconds after) = 0;
  virtual void pull_stick(nanoseconds after) = 0;

  // The tester's eyes.
  virtual bool light() = 0;             ///< the tester's photodiode
  virtual nanoseconds time_lit() = 0;   ///< in total
  virtual Distance plate_height() = 0;  ///< the tester's gauge
};

/// Makes a rig of one back end.
struct RigMaker {
  const char* name;
  std::function<std::unique_ptr<Rig>()> make;
};

/// The rigs of all back ends in this build (rigs.cpp).
std::vector<RigMaker> rig_makers();

}  // namespace plumbline
