#pragma once
/// Browsers that may command the printer. A person reads a code on the printer's screen and types it into a browser, which gets a token.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

/// 32 hexadecimal digits.
using PageToken = FixedText<33>;
/// 6 decimal digits.
using PageCode = FixedText<8>;

class Pairing {
 public:
  using HostClock = std::chrono::steady_clock;

  static constexpr std::size_t kMostBrowsers = 16;
  /// As long as the screen shows the code: StateRecorder::kCodeTime.
  static constexpr std::chrono::minutes kCodeTime{2};
  /// Wrong codes before a new one is needed. At three wrong codes a minute, trying a million takes 230 days.
  static constexpr unsigned kMostTries = 3;
  static constexpr std::chrono::minutes kBetweenCodes{1};

  /// @param folder  where the tokens are kept, so that a browser is paired once; empty: as long as this process lives
  /// @retval ErrorCode::kCannotOpen, kCannotRead
  [[nodiscard]] static Expected<Pairing> open(const std::string& folder);

  /// A code to show. It is the one before as long as that is good for half a minute.
  /// @retval ErrorCode::kBusy  it is too soon after wrong ones
  [[nodiscard]] Expected<PageCode> new_code(HostClock::time_point now);
  /// @returns a token for the browser that sent the code
  /// @retval ErrorCode::kBadSetting  it is wrong, or there is none any more
  [[nodiscard]] Expected<PageToken> pair(std::string_view code, HostClock::time_point now);
  /// A token without a code.
  PageToken add();

  bool knows(std::string_view token) const;

 private:
  using Bytes = std::array<std::uint8_t, 16>;

  Pairing() = default;

  std::array<Bytes, kMostBrowsers> tokens_{};  ///< all 0: none
  std::size_t next_ = 0;                       ///< is replaced if all are taken
  Descriptor file_;
  PageCode code_;
  HostClock::time_point valid_until_{};
  std::optional<HostClock::time_point> none_before_;
  unsigned tries_ = 0;
};

}  // namespace plumbline
