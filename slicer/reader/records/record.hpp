#pragma once
/// The layout of a record: a PLY element, a PCD point, or a row of columns.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "slicer/reader/stream/point_batch.hpp"

namespace plumbline::inline slicer {

enum class ScalarType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble
};

/// Bytes of a scalar in a binary file.
constexpr std::size_t size_of(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8: return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16: return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat: return 4;
    case ScalarType::kInt64:
    case ScalarType::kUint64:
    case ScalarType::kDouble: return 8;
  }
  return 1;
}
constexpr bool is_integer(ScalarType type) { return type < ScalarType::kFloat; }

/// Loads the scalar of `type` at `bytes`, which need not be aligned.
/// @param order  byte order of the file
double load_scalar(ScalarType type, const char* bytes, std::endian order);

/// A step through a record: a field to read, or what to skip before the next one. Adjacent unwanted fields are one step,
/// so ten thousand of them cost no more memory than one.
struct RecordStep {
  enum class Kind : std::uint8_t { kSkip, kField, kList };
  Kind kind = Kind::kSkip;
  ScalarType type = ScalarType::kInt8;  ///< of the field, or of the list's count
  ScalarType item = ScalarType::kInt8;  ///< of the list's items
  std::uint8_t slot = 0;                ///< of a field's value; of a list: whether it is the one wanted
  std::uint64_t bytes = 0;              ///< of a skip or a field, in a binary file
  std::uint64_t words = 0;              ///< of a skip, in a text file
};

/// The steps of one record, in the caller's memory.
class RecordLayout {
 public:
  RecordLayout() = default;
  explicit RecordLayout(std::span<RecordStep> room) : room_(room) {}

  /// Each returns false if there is no room for another step.
  [[nodiscard]] bool add_skip(std::uint64_t bytes, std::uint64_t words);
  [[nodiscard]] bool add_field(ScalarType type, std::size_t slot);
  /// @param wanted  its items are to be read, not skipped
  [[nodiscard]] bool add_list(ScalarType count, ScalarType item, bool wanted = false);

  std::span<const RecordStep> steps() const { return room_.first(used_); }
  bool has(std::size_t slot) const { return (slots_ >> slot) & 1U; }
  bool has_position() const { return has(kX) && has(kY) && has(kZ); }
  bool has_normal() const { return has(kNx) && has(kNy) && has(kNz); }
  /// With two radii or three.
  bool is_splat() const {
    constexpr unsigned kAll = ((1U << kRowSlots) - 1) & ~((1U << kSlots) - 1) & ~(1U << kThirdScale);
    return has_position() && (slots_ & kAll) == kAll;
  }
  bool has_lists() const { return lists_; }
  bool has_wanted_list() const { return wanted_list_; }
  /// Bytes of a record in a binary file, not counting lists. Saturates at the largest value.
  std::uint64_t bytes() const { return bytes_; }
  /// Bytes of the smallest record in a binary file: its lists are empty, the wanted one has the three corners of a triangle.
  std::uint64_t least_bytes() const;

 private:
  std::span<RecordStep> room_;
  std::size_t used_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint16_t slots_ = 0;
  bool lists_ = false;
  bool wanted_list_ = false;
};

}  // namespace plumbline::inline slicer
