#include "slicer/reader/records/record_binary.hpp"

#include <algorithm>
#include <cstring>

#include "slicer/reader/stream/number.hpp"

namespace plumbline::inline slicer {
namespace {

using Kind = RecordStep::Kind;

tl::unexpected<Error> fail_truncated(const ByteInput& input, const char* what, std::uint64_t read,
                                     std::uint64_t declared) {
  return input.fail(ErrorCode::kTruncated,
                    "the file ends at byte %llu, with %llu of the %llu %s that its header declares;\tcopy or export it "
                    "again",
                    static_cast<unsigned long long>(input.bytes_read()), static_cast<unsigned long long>(read),
                    static_cast<unsigned long long>(declared), what);
}

/// Reads one record piece by piece: it may be longer than the window.
/// @returns false if the file ends within it
Expected<bool> walk_record(ByteInput& input, const RecordLayout& layout, std::endian order, SlotValues& row) {
  for (const RecordStep& step : layout.steps()) {
    if (step.kind == Kind::kSkip) {
      const auto skipped = input.skip(step.bytes);
      PLUMBLINE_TRY(skipped);
      if (*skipped < step.bytes) return false;
      continue;
    }
    const std::size_t size = size_of(step.type);
    const auto ready = input.fill(size);
    PLUMBLINE_TRY(ready);
    if (*ready < size) return false;
    const double value = load_scalar(step.type, input.begin(), order);
    if (step.kind == Kind::kField) {
      row[step.slot] = value;
      input.consume(size);
      continue;
    }
    // 1e15 is more than any file holds, and a double is exact up to there.
    if (value < 0 || value > 1e15) {
      return input.fail(ErrorCode::kMalformed,
                        "byte %llu: a list claims to have %.0f items; the file is damaged, export it again",
                        static_cast<unsigned long long>(input.offset()), value);
    }
    input.consume(size);
    const std::uint64_t bytes = static_cast<std::uint64_t>(value) * size_of(step.item);
    const auto skipped = input.skip(bytes);
    PLUMBLINE_TRY(skipped);
    if (*skipped < bytes) return false;
  }
  return true;
}

/// Reads the fields of a record of a fixed size.
void load_row(const RecordLayout& layout, std::endian order, const char* at, SlotValues& row) {
  for (const RecordStep& step : layout.steps()) {
    if (step.kind == Kind::kField) {
      if (step.type == ScalarType::kFloat && order == std::endian::native) {  // nearly always
        float value = 0;
        std::memcpy(&value, at, sizeof value);
        row[step.slot] = static_cast<double>(value);
      } else {
        row[step.slot] = load_scalar(step.type, at, order);
      }
    }
    at += step.bytes;
  }
}

/// Reads records of a fixed size, as many at a time as the window holds.
Status read_fixed(ByteInput& input, const RecordLayout& layout, std::uint64_t count, std::endian order,
                  PointBatch& batch) {
  const auto size = static_cast<std::size_t>(layout.bytes());
  SlotValues row = {};
  for (std::uint64_t done = 0; done < count;) {
    const auto ready = input.fill(size);
    PLUMBLINE_TRY(ready);
    if (*ready < size) return fail_truncated(input, "points", done, count);
    const std::uint64_t whole = std::min<std::uint64_t>(count - done, *ready / size);
    for (std::uint64_t i = 0; i < whole; ++i) {
      load_row(layout, order, input.begin(), row);
      input.consume(size);
      batch.add(row);
      if (batch.full()) PLUMBLINE_TRY(batch.flush());
    }
    done += whole;
  }
  return {};
}

}  // namespace

Status read_binary_points(ByteInput& input, const RecordLayout& layout, std::uint64_t count, std::endian order,
                          PointBatch& batch) {
  if (!layout.has_lists() && layout.bytes() <= input.capacity()) {
    return read_fixed(input, layout, count, order, batch);
  }
  SlotValues row = {};
  for (std::uint64_t done = 0; done < count; ++done) {
    const auto whole = walk_record(input, layout, order, row);
    PLUMBLINE_TRY(whole);
    if (!*whole) return fail_truncated(input, "points", done, count);
    batch.add(row);
    if (batch.full()) PLUMBLINE_TRY(batch.flush());
  }
  return {};
}

Status skip_binary_records(ByteInput& input, const RecordLayout& layout, std::uint64_t count, std::endian order) {
  if (!layout.has_lists()) {
    const std::uint64_t bytes = saturating_multiply(layout.bytes(), count);
    const auto skipped = input.skip(bytes);
    PLUMBLINE_TRY(skipped);
    if (*skipped < bytes) return fail_truncated(input, "records before its points", *skipped / layout.bytes(), count);
    return {};
  }
  SlotValues row = {};
  for (std::uint64_t done = 0; done < count; ++done) {
    const auto whole = walk_record(input, layout, order, row);
    PLUMBLINE_TRY(whole);
    if (!*whole) return fail_truncated(input, "records before its points", done, count);
  }
  return {};
}

}  // namespace plumbline::inline slicer
