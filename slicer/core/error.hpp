#pragma once
/// Errors: what the world does wrong, as a value. Nothing here takes memory from the heap.

#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tl/expected.hpp>

namespace plumbline {

/// Every way in which the world can be wrong. The numbers are stable: scripts and logs may rely on them.
enum class ErrorCode : std::uint16_t {
  kCannotOpen = 1,      ///< a file could not be opened or created
  kCannotRead = 2,      ///< the medium failed while reading
  kCannotWrite = 3,     ///< the medium failed while writing
  kUnknownFormat = 10,  ///< the bytes are not a scan format that plumbline reads
  kMalformed = 11,      ///< a known format, broken at a place that the message names
  kTruncated = 12,      ///< the file ends before what its header promised
  kNoPoints = 13,       ///< nothing to print: no usable point in the scan
  kUnsupported = 14,    ///< valid, but a variant that plumbline does not read
  kOutOfMemory = 20,    ///< a stage needs more than the arena has left
  kDoesNotFit = 30,     ///< object larger than the panel or the travel of the Z stage
  kBadSetting = 31,     ///< an option or a key of a board file is wrong
  kNoSurface = 32,      ///< points, but no surface in them
  kCancelled = 40,      ///< asked to stop

  // The machine's. After the reason: what the user does next.
  kPowerLost = 50,         ///< no device answers any more, and nothing that is written now will last: restart, resume
  kBusy = 51,              ///< a device was asked for something while it does the last thing: a mistake in the firmware
  kDeviceTimeout = 52,     ///< a device did not end what it had begun: switch the printer off and on
  kNoStick = 60,           ///< plug one in
  kStickGone = 61,         ///< pulled while it was needed: plug it in and start again
  kMountFailed = 62,       ///< no partition or file system that can be read: format the stick as FAT32 or exFAT
  kMaskNotPresented = 70,  ///< light was asked for without a mask on the panel: a mistake in the firmware
  kFlipTimeout = 71,       ///< the panel did not take a mask in time: check its cable
  kPanelFailed = 72,       ///< the panel does not answer: check its cable
  kExposureTooLong = 80,   ///< above the lamp's limit: lower the exposure time in the profile
  kLampLit = 81,          ///< refused what must not happen under light: a mistake in the firmware, or the lamp is stuck
  kLampStuckOn = 82,      ///< light although it was turned off: pull the plug
  kLampDead = 83,         ///< no light although it was turned on: check lamp and fuse
  kLampFailed = 84,       ///< the lamp's keeper or line does not answer: nothing was lit; restart
  kDoseOff = 85,          ///< the lamp gave another dose than it was asked for: check lamp and its supply
  kOutsideTravel = 90,    ///< a height that the stage can't reach: nothing moved
  kNotHomed = 91,         ///< the stage does not know its height: home it
  kStageMoving = 92,      ///< refused what must not happen while the stage moves: a mistake in the firmware
  kEndStopNotFound = 93,  ///< homing ran its whole way: check the end stop's switch and cable
  kEndStopStuck = 94,     ///< the end stop is pressed where it can't be: check its switch
  kStageStalled = 95,     ///< the motor could not follow: look for what blocks the stage, then home
  kCoverOpen = 100,       ///< close the cover
  kSensorDead = 110,      ///< a temperature sensor does not answer: check its plug
};

/// @returns the code's name without the k, such as "Truncated".
std::string_view to_string(ErrorCode code);

/// A code and a sentence for the user: the file, the place, what was found, what to do.
class Error {
 public:
  static constexpr std::size_t kCapacity = 448;  ///< bytes of message, terminator included; longer ones are cut

  /// printf-style. Never allocates.
  [[gnu::format(printf, 2, 3)]] static Error format(ErrorCode code, const char* pattern, ...);

  ErrorCode code() const { return code_; }
  const char* message() const { return message_; }
  /// Puts `prefix` and ": " before the message, so that a caller who knows the file can say so.
  Error with_prefix(std::string_view prefix) const;

 private:
  [[gnu::format(printf, 2, 0)]] static Error format_list(ErrorCode code, const char* pattern, std::va_list args);
  friend tl::unexpected<Error> fail(ErrorCode code, const char* pattern, ...);

  ErrorCode code_ = ErrorCode::kMalformed;
  char message_[kCapacity] = {};
};

template <class T>
using Expected = tl::expected<T, Error>;
using Status = tl::expected<void, Error>;

/// The unexpected side of an Expected<T> or a Status, with a printf-style message that the compiler checks.
[[nodiscard, gnu::format(printf, 2, 3)]] tl::unexpected<Error> fail(ErrorCode code, const char* pattern, ...);

}  // namespace plumbline

/// Returns the error of an expression that is a Status or an Expected, if it has one.
#define PLUMBLINE_TRY(expression)                                                                       \
  do {                                                                                                  \
    auto&& plumbline_try_result = (expression);                                                         \
    if (!plumbline_try_result) return tl::unexpected<::plumbline::Error>(plumbline_try_result.error()); \
  } while (false)
