#include "firmware/io/hashing_source.hpp"

namespace plumbline {

Expected<std::size_t> HashingSource::read(std::span<std::byte> buffer) {
  const auto got = source_.read(buffer);
  if (got) hash_.add(buffer.first(*got));
  return got;
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

}  // namespace plumbline
