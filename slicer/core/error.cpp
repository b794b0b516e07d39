#include "slicer/core/error.hpp"

#include <cstdio>

namespace plumbline {

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
  }
  return "Unknown";
}

Error Error::format(ErrorCode code, const char* pattern, ...) {
  Error error;
  error.code_ = code;
  va_list args;
  va_start(args, pattern);
  std::vsnprintf(error.message_, sizeof error.message_, pattern, args);
  va_end(args);
  return error;
}

Error Error::with_prefix(std::string_view prefix) const {
  return format(code_, "%.*s: %s", static_cast<int>(prefix.size()), prefix.data(), message_);
}

}  // namespace plumbline
