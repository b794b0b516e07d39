#include "slicer/reader/reread_source.hpp"

#include <algorithm>
#include <cstring>

#include "slicer/core/numbers/mib.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::inline slicer {
namespace {

constexpr const char* kStage = "read";

}  // namespace

Expected<RereadSource> RereadSource::open(ByteSource& source, Arena& arena) {
  RereadSource reread(source);
  const Status rewound = source.rewind();
  if (rewound) return reread;
  if (rewound.error().code() != ErrorCode::kUnsupported) return tl::unexpected<Error>(rewound.error());
  reread.rewinds_ = false;
  const auto head = arena.take_top<std::byte>(kHeadBytes, kStage);
  PLUMBLINE_TRY(head);
  reread.kept_ = *head;
  return reread;
}

Status RereadSource::keep_all(Arena& arena) {
  if (rewinds_ || keeps_all_) return {};
  const std::uint64_t most = arena.available();
  const std::uint64_t wanted = source_->size().value_or(most / 4);
  const auto room = arena.take_top<std::byte>(static_cast<std::size_t>(std::clamp<std::uint64_t>(
                                                  wanted, kHeadBytes, std::max<std::uint64_t>(most, kHeadBytes))),
                                              kStage);
  PLUMBLINE_TRY(room);
  std::memcpy(room->data(), kept_.data(), filled_);
  kept_ = *room;
  keeps_all_ = true;
  return {};
}

Expected<std::size_t> RereadSource::read(std::span<std::byte> buffer) {
  if (rewinds_) return source_->read(buffer);
  if (at_ < filled_) {
    const std::size_t count = std::min(buffer.size(), filled_ - at_);
    std::memcpy(buffer.data(), kept_.data() + at_, count);
    at_ += count;
    return count;
  }
  const std::size_t room = kept_.size() - filled_;
  if (is_peeking_) {
    if (room == 0) return std::size_t{0};
    buffer = buffer.first(std::min(buffer.size(), room));
  }
  const auto got = source_->read(buffer);
  PLUMBLINE_TRY(got);
  if (!is_peeking_ && !keeps_all_) {
    lost_ = true;
    return got;
  }
  if (*got > room) {
    return fail(
        ErrorCode::kOutOfMemory,
        "%s: the file is read twice, this one comes through a pipe, and the arena has only %.1f MiB for a copy.\t"
        "Give it as a file, or use a larger arena",
        PrintableText(name(), 96).c_str(), mib(kept_.size()));
  }
  std::memcpy(kept_.data() + filled_, buffer.data(), *got);
  filled_ += *got;
  at_ += *got;
  return got;
}

Status RereadSource::rewind() {
  is_peeking_ = false;
  if (rewinds_) return source_->rewind();
  if (lost_) return ByteSource::rewind();
  at_ = 0;
  return {};
}

}  // namespace plumbline::inline slicer
