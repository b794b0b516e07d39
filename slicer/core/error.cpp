#include "slicer/core/error.hpp"

#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>

#include "slicer/core/words/printable_text.hpp"

namespace plumbline::inline slicer {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::kCannotOpen: return "CannotOpen";
    case ErrorCode::kCannotRead: return "CannotRead";
    case ErrorCode::kCannotWrite: return "CannotWrite";
    case ErrorCode::kUnknownFormat: return "UnknownFormat";
    case ErrorCode::kMalformed: return "Malformed";
    case ErrorCode::kTruncated: return "Truncated";
    case ErrorCode::kNoPoints: return "NoPoints";
    case ErrorCode::kUnsupported: return "Unsupported";
    case ErrorCode::kOutOfMemory: return "OutOfMemory";
    case ErrorCode::kDoesNotFit: return "DoesNotFit";
    case ErrorCode::kBadSetting: return "BadSetting";
    case ErrorCode::kNoSurface: return "NoSurface";
    case ErrorCode::kCancelled: return "Cancelled";
    case ErrorCode::kPowerLost: return "PowerLost";
    case ErrorCode::kBusy: return "Busy";
    case ErrorCode::kDeviceTimeout: return "DeviceTimeout";
    case ErrorCode::kNoStick: return "NoStick";
    case ErrorCode::kStickGone: return "StickGone";
    case ErrorCode::kMountFailed: return "MountFailed";
    case ErrorCode::kMaskNotPresented: return "MaskNotPresented";
    case ErrorCode::kFlipTimeout: return "FlipTimeout";
    case ErrorCode::kPanelFailed: return "PanelFailed";
    case ErrorCode::kExposureTooLong: return "ExposureTooLong";
    case ErrorCode::kLampLit: return "LampLit";
    case ErrorCode::kLampStuckOn: return "LampStuckOn";
    case ErrorCode::kLampDead: return "LampDead";
    case ErrorCode::kLampFailed: return "LampFailed";
    case ErrorCode::kDoseOff: return "DoseOff";
    case ErrorCode::kOutsideTravel: return "OutsideTravel";
    case ErrorCode::kNotHomed: return "NotHomed";
    case ErrorCode::kStageMoving: return "StageMoving";
    case ErrorCode::kEndStopNotFound: return "EndStopNotFound";
    case ErrorCode::kEndStopStuck: return "EndStopStuck";
    case ErrorCode::kStageStalled: return "StageStalled";
    case ErrorCode::kCoverOpen: return "CoverOpen";
    case ErrorCode::kSensorDead: return "SensorDead";
  }
  return "Unknown";
}

struct Error::Row {
  std::atomic<std::uint32_t> users = 0;  ///< errors that have it; 0: free
  std::uint16_t advice_at = 0;           ///< in the message; 0: no advice
  std::array<char, kCapacity> message{};
  Told told;
};

Error::Row Error::rows[kRows];

Error::Error(ErrorCode code) : code_(code) {
  for (Row& row : rows) {
    std::uint32_t free = 0;
    if (!row.users.compare_exchange_strong(free, 1)) continue;
    row_ = &row;
    row.advice_at = 0;
    row.told = {};
    return;
  }
}

Error::Error(const Error& other) noexcept : code_(other.code_), row_(other.row_) {
  if (row_ != nullptr) ++row_->users;
}

Error::~Error() {
  if (row_ != nullptr) --row_->users;
}

const char* Error::message() const { return row_ != nullptr ? row_->message.data() : to_string(code_).data(); }

std::string_view Error::advice() const {
  return row_ != nullptr && row_->advice_at > 0 ? message() + row_->advice_at : std::string_view();
}

const Told& Error::told() const {
  static const Told kNothing;
  return row_ != nullptr ? row_->told : kNothing;
}

Error& Error::tell(const Told& told) {
  if (row_ != nullptr) row_->told = told;
  return *this;
}

Error Error::format_list(ErrorCode code, const char* pattern, std::va_list args) {
  Error error(code);
  if (error.row_ == nullptr) return error;
  Row& row = *error.row_;
  std::va_list again;
  va_copy(again, args);
  // Room for a character more than a message has, so that PrintableText sees what has to be cut.
  std::array<char, kCapacity + 1> raw{};
  std::vsnprintf(raw.data(), raw.size(), pattern, args);
  std::string_view advice;
  std::string_view finding = raw.data();
  if (const char* const tab = std::strchr(pattern, '\t')) {
    char beginning[kCapacity];
    std::snprintf(beginning, sizeof beginning, "%.*s", static_cast<int>(tab - pattern), pattern);
    // The compiler has checked the pattern, and this is its beginning.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    const int length = std::vsnprintf(nullptr, 0, beginning, again);
#pragma GCC diagnostic pop
    if (length >= 0 && static_cast<std::size_t>(length) < finding.size()) {
      advice = finding.substr(static_cast<std::size_t>(length) + 1);
      finding = finding.substr(0, static_cast<std::size_t>(length));
    }
  }
  va_end(again);
  std::size_t size = PrintableText(finding, kCapacity - 1).view().copy(row.message.data(), kCapacity - 1);
  if (!advice.empty() && size + 1 < kCapacity - 1) {
    row.message[size++] = ' ';
    row.advice_at = static_cast<std::uint16_t>(size);
    size += PrintableText(advice, kCapacity - 1 - size).view().copy(row.message.data() + size, kCapacity - 1 - size);
  }
  row.message[size] = '\0';
  return error;
}

Error Error::format(ErrorCode code, const char* pattern, ...) {
  std::va_list args;
  va_start(args, pattern);
  Error error = format_list(code, pattern, args);
  va_end(args);
  return error;
}

tl::unexpected<Error> fail(ErrorCode code, const char* pattern, ...) {
  std::va_list args;
  va_start(args, pattern);
  Error error = Error::format_list(code, pattern, args);
  va_end(args);
  return tl::unexpected<Error>(error);
}

tl::unexpected<Error> telling(const Told& told, tl::unexpected<Error> error) {
  error.value().tell(told);
  return error;
}

Error Error::with_prefix(std::string_view prefix) const {
  const auto length = static_cast<int>(prefix.size());
  if (advice().empty()) return format(code_, "%.*s: %s", length, prefix.data(), message()).tell(told());
  const int found = static_cast<int>(advice().data() - message()) - 1;
  return format(code_, "%.*s: %.*s\t%s", length, prefix.data(), found, message(), advice().data()).tell(told());
}

std::string_view Error::finding() const {
  std::string_view text = message();
  if (advice().empty()) return text;
  text.remove_suffix(advice().size());
  while (!text.empty() && std::string_view(" :.;").find(text.back()) != std::string_view::npos) text.remove_suffix(1);
  return text;
}

}  // namespace plumbline::inline slicer
