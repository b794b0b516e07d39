#pragma once
/// Errors as values, for everything that can go wrong outside the program. Nothing here allocates.

#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "slicer/core/words/told.hpp"

namespace plumbline::inline slicer {

/// Kinds of errors. The numbers are stable: scripts and logs may rely on them.
enum class ErrorCode : std::uint16_t {
  kCannotOpen = 1,      ///< a file could not be opened or created
  kCannotRead = 2,      ///< the medium failed while reading
  kCannotWrite = 3,     ///< the medium failed while writing
  kUnknownFormat = 10,  ///< not a scan format that plumbline reads
  kMalformed = 11,      ///< a known format, but damaged at the place that the message names
  kTruncated = 12,      ///< the file ends before all the data that its header declares
  kNoPoints = 13,       ///< nothing to print: the scan has no usable point
  kUnsupported = 14,    ///< valid, but a variant of the format that plumbline does not read
  kOutOfMemory = 20,    ///< a stage needs more memory than the arena has left
  kDoesNotFit = 30,     ///< the object is larger than the panel or the travel of the Z stage
  kBadSetting = 31,     ///< an option or a key in a settings file is wrong
  kNoSurface = 32,      ///< the points form no surface
  kCancelled = 40,      ///< the caller asked to stop

  // Errors of the machine: the reason, then what the user does next.
  kPowerLost = 50,         ///< power is failing: devices no longer answer and writes may be lost; restart and resume
  kBusy = 51,              ///< a device got a request before its last one was done: a firmware bug
  kDeviceTimeout = 52,     ///< a device did not finish in time: switch the printer off and on
  kNoStick = 60,           ///< no stick: plug one in
  kStickGone = 61,         ///< the stick was pulled while in use: plug it in and start again
  kMountFailed = 62,       ///< no readable partition or file system: format the stick as FAT32 or exFAT
  kMaskNotPresented = 70,  ///< exposure requested with no mask on the panel: a firmware bug
  kFlipTimeout = 71,       ///< the panel did not show a mask in time: check its cable
  kPanelFailed = 72,       ///< the panel does not answer: check its cable
  kExposureTooLong = 80,   ///< above the lamp's limit: lower the exposure time in the profile
  kLampLit = 81,           ///< refused because the lamp is lit: a firmware bug, or the lamp is stuck on
  kLampStuckOn = 82,       ///< the lamp stays lit after it was switched off: pull the plug
  kLampDead = 83,          ///< the lamp stays dark after it was switched on: check lamp and fuse
  kLampFailed = 84,        ///< the lamp's keeper or line does not answer, the lamp is dark: restart
  kDoseOff = 85,           ///< the lamp gave a dose other than requested: check the lamp and its supply
  kOutsideTravel = 90,     ///< a height that the Z stage can't reach: nothing moved
  kNotHomed = 91,          ///< the height of the Z stage is unknown: home it
  kStageMoving = 92,       ///< refused because the Z stage is moving: a firmware bug
  kEndStopNotFound = 93,   ///< homing used its whole travel: check the end stop's switch and cable
  kEndStopStuck = 94,      ///< the end stop is pressed where it can't be: check its switch
  kStageStalled = 95,      ///< the motor lost steps: remove what blocks the Z stage, then home it
  kCoverOpen = 100,        ///< close the cover
  kSensorDead = 110,       ///< a temperature sensor does not answer: check its plug
};

/// @returns the code's name without the k, such as "Truncated"
std::string_view to_string(ErrorCode code);

/// A code and a message for the user: file, place, what was found, what to do. Where it is shown to people who read another language than
/// English, it also has what is told as a code with values. What it says lies in a table of fixed size that all errors share, so an
/// Error is two words; copies share a row.
class Error {
 public:
  /// Bytes of a message, terminator included; longer ones are cut.
  static constexpr std::size_t kCapacity = 448;
  /// Errors with different messages at a time. One more says only its code's name.
  static constexpr std::size_t kRows = 64;

  Error(const Error& other) noexcept;
  Error(Error&& other) noexcept : code_(other.code_), row_(std::exchange(other.row_, nullptr)) {}
  Error& operator=(Error other) noexcept {
    std::swap(code_, other.code_);
    std::swap(row_, other.row_);
    return *this;
  }
  ~Error();

  /// Formats a message as printf does. A tab in the pattern separates what was found from what to do, and is shown as a
  /// space: "%s: is a folder.\tName the scan in it". Never allocates.
  [[gnu::format(printf, 2, 3)]] static Error format(ErrorCode code, const char* pattern, ...);
  [[gnu::format(printf, 2, 0)]] static Error format_list(ErrorCode code, const char* pattern, std::va_list args);

  ErrorCode code() const { return code_; }
  const char* message() const;
  /// The message without its advice.
  std::string_view finding() const;
  /// What to do; empty if the message doesn't say.
  std::string_view advice() const;
  /// The same error with `prefix` and ": " before the message, for a caller that knows the file's name.
  Error with_prefix(std::string_view prefix) const;

  /// What the message says; empty() if it has no code of its own.
  const Told& told() const;
  /// @pre there is no copy of it yet
  Error& tell(const Told& told);

 private:
  struct Row;
  static Row rows[kRows];

  explicit Error(ErrorCode code);

  ErrorCode code_;
  Row* row_ = nullptr;  ///< null: all were taken
};

template <class T>
using Expected = tl::expected<T, Error>;
using Status = tl::expected<void, Error>;

/// An error to return from a function that returns Expected<T> or Status; see Error::format(). The compiler checks the message as printf's.
[[nodiscard, gnu::format(printf, 2, 3)]] tl::unexpected<Error> fail(ErrorCode code, const char* pattern, ...);
/// An error that also has what its message says as a code: return telling(Told(ToldCode::kFileEmpty), fail(...)).
[[nodiscard]] tl::unexpected<Error> telling(const Told& told, tl::unexpected<Error> error);

}  // namespace plumbline::inline slicer

/// Returns from the enclosing function with the error of a Status or an Expected, if it has one.
#define PLUMBLINE_TRY(expression)                                                                       \
  do {                                                                                                  \
    auto&& plumbline_try_result = (expression);                                                         \
    if (!plumbline_try_result) return tl::unexpected<::plumbline::Error>(plumbline_try_result.error()); \
  } while (false)
