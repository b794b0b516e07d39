#include "slicer/reader/formats/pcd/lzf_stream.hpp"

#include <cstring>

#include "slicer/core/words/plural.hpp"

namespace plumbline::inline slicer {

Expected<std::span<const char>> LzfStream::next() {
  if (end_ > kReach) {
    std::memmove(window_.data(), window_.data() + end_ - kReach, kReach);
    end_ = kReach;
  }
  const std::size_t start = end_;
  while (compressed_left_ > 0 && window_.size() - end_ >= kLongestStep) {
    PLUMBLINE_TRY(need(1));
    const auto control = static_cast<unsigned char>(*input_.begin());
    input_.consume(1);
    --compressed_left_;
    PLUMBLINE_TRY(control < 32 ? literals(control + 1U) : reference(control));
  }
  return std::span<const char>(window_).subspan(start, end_ - start);
}

Status LzfStream::need(std::size_t bytes) {
  if (compressed_left_ < bytes) {
    return input_.fail(
        ErrorCode::kMalformed,
        "byte %llu: the compressed block ends in the middle of a step: it is damaged.\tSave the file again",
        static_cast<unsigned long long>(input_.offset()));
  }
  const auto ready = input_.fill(bytes);
  PLUMBLINE_TRY(ready);
  if (*ready < bytes) {
    return input_.fail(
        ErrorCode::kTruncated,
        "the file ends at byte %llu, %llu byte%s before its compressed block does;\tcopy or save it again",
        static_cast<unsigned long long>(input_.bytes_read()),
        static_cast<unsigned long long>(compressed_left_ - *ready), plural_s(compressed_left_ - *ready));
  }
  return {};
}

Status LzfStream::literals(std::size_t count) {
  PLUMBLINE_TRY(need(count));
  std::memcpy(window_.data() + end_, input_.begin(), count);
  input_.consume(count);
  compressed_left_ -= count;
  end_ += count;
  return {};
}

Status LzfStream::reference(unsigned control) {
  std::size_t length = 2 + (control >> 5);
  const std::size_t extra = length == 2 + 7 ? 2 : 1;
  PLUMBLINE_TRY(need(extra));
  if (extra == 2) length += static_cast<unsigned char>(input_.begin()[0]);
  const std::size_t distance =
      (std::size_t{control & 31U} << 8) + static_cast<unsigned char>(input_.begin()[extra - 1]) + 1;
  if (distance > end_) {
    return input_.fail(ErrorCode::kMalformed,
                       "byte %llu: the compressed block refers to %zu byte%s before its start;\tsave the file again",
                       static_cast<unsigned long long>(input_.offset()), distance - end_, plural_s(distance - end_));
  }
  input_.consume(extra);
  compressed_left_ -= extra;
  // Byte by byte: where source and target overlap, the bytes between them repeat.
  char* to = window_.data() + end_;
  const char* from = to - distance;
  for (std::size_t i = 0; i < length; ++i) to[i] = from[i];
  end_ += length;
  return {};
}

}  // namespace plumbline::inline slicer
