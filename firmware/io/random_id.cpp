#include "firmware/io/random_id.hpp"

#include <sys/random.h>

#include <charconv>

#include "slicer/core/numbers/mix64.hpp"

namespace plumbline::firmware {

RandomIds::RandomIds(std::uint64_t seed) : at_(seed) {
  // Eight bytes come whole; a signal may interrupt the wait for the kernel's first entropy.
  while (at_ == 0 && ::getrandom(&at_, sizeof at_, 0) != static_cast<ssize_t>(sizeof at_)) at_ = 0;
}

std::uint64_t RandomIds::next() {
  // mix64 is a bijection: ids repeat only when the counter does.
  const std::uint64_t id = mix64(at_ += kGoldenStep64);
  return id != 0 ? id : next();
}

FixedText<20> id_text(std::uint64_t id) {
  FixedText<20> text;
  text.add("%016llx", static_cast<unsigned long long>(id));
  return text;
}

std::optional<std::uint64_t> id_of(std::string_view text) {
  std::uint64_t id = 0;
  const char* const end = text.data() + text.size();
  const bool whole = text.size() == 16 && std::from_chars(text.data(), end, id, 16).ptr == end;
  return whole && id != 0 && id_text(id).view() == text ? std::optional(id) : std::nullopt;
}

}  // namespace plumbline::firmware
