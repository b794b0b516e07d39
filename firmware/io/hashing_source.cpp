#include "firmware/io/hashing_source.hpp"

#include <algorithm>

namespace plumbline::firmware {

Expected<std::size_t> HashingSource::read(std::span<std::byte> buffer) {
  const auto got = source_.read(buffer);
  PLUMBLINE_TRY(got);
  at_ += *got;
  if (at_ > hashed_) {
    const auto fresh = static_cast<std::size_t>(std::min<std::uint64_t>(*got, at_ - hashed_));
    hash_.add(buffer.subspan(*got - fresh, fresh));
    hashed_ = at_;
  }
  return got;
}

Status HashingSource::rewind() {
  PLUMBLINE_TRY(source_.rewind());
  at_ = 0;
  return {};
}

HashingSources::HashingSources(ScanSources scan) : count_(scan.size()) {
  for (std::size_t i = 0; i < count_; ++i) pointers_[i] = &hashing_[i].emplace(*scan[i]);
}

std::uint64_t HashingSources::hash() const {
  if (count_ == 1) return hashing_[0]->hash();
  Hash64 all;
  for (std::size_t i = 0; i < count_; ++i) all.add_value(hashing_[i]->hash());
  return all.value();
}

}  // namespace plumbline::firmware
