#pragma once
/// Random numbers that name a job or a question. A name of yesterday, or of before a restart, names nothing today.

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/io/text/fixed_text.hpp"

namespace plumbline::firmware {

/// A stream of ids, none of them 0, no two of them equal. Those of another process begin elsewhere among 2^64.
class RandomIds {
 public:
  /// @param seed  for tests, whose ids are then always the same; 0: from the kernel
  explicit RandomIds(std::uint64_t seed = 0);
  std::uint64_t next();

 private:
  std::uint64_t at_;
};

/// 16 hexadecimal digits: numbers of JSON hold only 53 bits everywhere.
FixedText<20> id_text(std::uint64_t id);
/// @returns none: it is not what id_text() writes, or 0
std::optional<std::uint64_t> id_of(std::string_view text);

}  // namespace plumbline::firmware
