#pragma once
/// What an examination of a board finds.

#include <cstdint>
#include <string>

namespace plumbline::inline hal {

/// The state of one device or permission that the printer needs.
struct MachineFinding {
  enum class Verdict : std::uint8_t {
    kGood,
    kPoor,   ///< it prints, but not as well as it could
    kWrong,  ///< it does not print
  } verdict = Verdict::kGood;
  std::string what;    ///< "the lamp's line"
  std::string found;   ///< "gpiochip0 line 17"
  std::string advice;  ///< what to do; empty: nothing
};

}  // namespace plumbline::inline hal
