#pragma once
/// Browsers that may command the printer: each has a token. They are listed, and can be forgotten.

#include <array>
#include <cstdint>
#include <ctime>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline page {

/// 32 hexadecimal digits.
using PageToken = FixedText<33>;

/// Fills bytes from the kernel's generator. Ends the process if that fails, since there would be no secrets.
void fill_random(std::span<std::uint8_t> bytes);
/// Takes as long for any two texts of a length, so that time tells nothing of where they differ.
bool is_same_secret(std::string_view a, std::string_view b);

class PairedBrowsers {
 public:
  static constexpr std::size_t kMost = 16;
  /// The time of the last command is written so much later than the last time at least: the storage is flash.
  static constexpr std::time_t kBetweenWrites = 24 * 3600;

  struct Browser {
    std::uint32_t number = 0;    ///< 0: none. Never used again
    std::uint32_t order = 0;     ///< rises with each command: the lowest makes room for a new browser
    std::int64_t paired_at = 0;  ///< seconds since 1970 by this machine's clock; 0: not known
    std::int64_t seen_at = 0;    ///< its last command
    char name[48] = {};          ///< as the browser calls itself, in printable ASCII
  };

  /// @param folder  where they are kept, so that a browser is paired once; empty: as long as this process lives
  /// @retval ErrorCode::kCannotOpen, kCannotRead
  [[nodiscard]] static Expected<PairedBrowsers> open(const std::string& folder);

  /// Pairs a browser.
  /// @param name  as it calls itself: anything
  /// @param now   by this machine's clock
  PageToken add(std::string_view name, std::time_t now);
  /// @returns the browser's number
  std::optional<std::uint32_t> find(std::string_view token) const;
  /// A paired browser has sent a command.
  void seen(std::uint32_t number, std::time_t now);
  /// @returns whether there was such a browser
  bool forget(std::uint32_t number);

  /// Those without a number are none.
  std::span<const Browser> list() const { return file_.browsers; }

 private:
  using Token = std::array<std::uint8_t, 16>;
  /// What the file holds.
  struct File {
    std::uint64_t hash = 0;  ///< of what follows
    std::uint32_t last_number = 0;
    std::uint32_t last_order = 0;
    std::array<Browser, kMost> browsers{};
    std::array<Token, kMost> tokens{};
  };

  PairedBrowsers() = default;
  static std::uint64_t hash_of(const File& file);
  void write();

  File file_;
  Descriptor kept_;
};

}  // namespace plumbline::firmware::inline page
