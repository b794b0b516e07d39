#include "slicer/reader/records/record.hpp"

#include <algorithm>

#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

template <class T>
double load(const char* bytes, std::endian order) {
  char copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof copy);
  if (order != std::endian::native) std::reverse(copy, copy + sizeof copy);
  return static_cast<double>(std::bit_cast<T>(copy));
}

}  // namespace

double load_scalar(ScalarType type, const char* bytes, std::endian order) {
  switch (type) {
    case ScalarType::kInt8: return load<std::int8_t>(bytes, order);
    case ScalarType::kUint8: return load<std::uint8_t>(bytes, order);
    case ScalarType::kInt16: return load<std::int16_t>(bytes, order);
    case ScalarType::kUint16: return load<std::uint16_t>(bytes, order);
    case ScalarType::kInt32: return load<std::int32_t>(bytes, order);
    case ScalarType::kUint32: return load<std::uint32_t>(bytes, order);
    case ScalarType::kInt64: return load<std::int64_t>(bytes, order);
    case ScalarType::kUint64: return load<std::uint64_t>(bytes, order);
    case ScalarType::kFloat: return load<float>(bytes, order);
    case ScalarType::kDouble: return load<double>(bytes, order);
  }
  return 0;
}

bool RecordLayout::add_skip(std::uint64_t bytes, std::uint64_t words) {
  bytes_ = saturating_add(bytes_, bytes);
  if (used_ > 0 && room_[used_ - 1].kind == RecordStep::Kind::kSkip) {
    RecordStep& last = room_[used_ - 1];
    last.bytes = saturating_add(last.bytes, bytes);
    last.words = saturating_add(last.words, words);
    return true;
  }
  if (used_ == room_.size()) return false;
  room_[used_++] = {.kind = RecordStep::Kind::kSkip, .bytes = bytes, .words = words};
  return true;
}

bool RecordLayout::add_field(ScalarType type, std::size_t slot) {
  // If two fields have the same name, the first counts.
  if (has(slot)) return add_skip(size_of(type), 1);
  if (used_ == room_.size()) return false;
  bytes_ = saturating_add(bytes_, size_of(type));
  slots_ = static_cast<std::uint16_t>(slots_ | (1U << slot));
  room_[used_++] = {
      .kind = RecordStep::Kind::kField, .type = type, .slot = static_cast<std::uint8_t>(slot), .bytes = size_of(type)};
  return true;
}

bool RecordLayout::add_list(ScalarType count, ScalarType item, bool wanted) {
  if (used_ == room_.size()) return false;
  lists_ = true;
  const bool first = wanted && !wanted_list_;
  wanted_list_ |= wanted;
  room_[used_++] = {
      .kind = RecordStep::Kind::kList, .type = count, .item = item, .slot = static_cast<std::uint8_t>(first ? 1 : 0)};
  return true;
}

std::uint64_t RecordLayout::least_bytes() const {
  std::uint64_t bytes = bytes_;
  for (const RecordStep& step : steps()) {
    if (step.kind != RecordStep::Kind::kList) continue;
    bytes = saturating_add(bytes, size_of(step.type) + (step.slot == 1 ? 3 * size_of(step.item) : 0));
  }
  return bytes;
}

}  // namespace plumbline::inline slicer
