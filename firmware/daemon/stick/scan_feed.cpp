#include "firmware/daemon/stick/scan_feed.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace plumbline::firmware {

ScanFeed::ScanFeed(std::span<StickFile> files) {
  const std::size_t share = bytes_.size() / files.size();
  pipes_.reserve(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    Pipe& pipe = pipes_.emplace_back();
    pipe.file = &files[i];
    pipe.room = std::span(bytes_).subspan(i * share, share);
  }
}

Expected<std::vector<int>> ScanFeed::open() {
  std::vector<int> descriptors;
  for (Pipe& pipe : pipes_) {
    if (const auto file = pipe.file->descriptor()) {
      descriptors.push_back(*file);
      continue;
    }
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) return fail(ErrorCode::kCannotRead, "no pipe: %s", std::strerror(errno));
    pipe.ours = Descriptor(ends[0]);
    pipe.into = Descriptor(ends[1]);
    if (::fcntl(pipe.into.get(), F_SETFL, O_NONBLOCK) != 0) {
      return fail(ErrorCode::kCannotRead, "no pipe: %s", std::strerror(errno));
    }
    descriptors.push_back(pipe.ours.get());
  }
  return descriptors;
}

void ScanFeed::opened() {
  for (Pipe& pipe : pipes_) pipe.ours = Descriptor();
}

Expected<bool> ScanFeed::pump() {
  bool moved = false;
  for (Pipe& pipe : pipes_) {
    const auto pumped = pump(pipe);
    PLUMBLINE_TRY(pumped);
    moved |= *pumped;
  }
  return moved;
}

Expected<bool> ScanFeed::pump(Pipe& pipe) {
  if (!pipe.into.is_open()) return false;
  if (pipe.from == pipe.to) {
    const auto got = pipe.file->read(pipe.room);
    PLUMBLINE_TRY(got);
    pipe.from = 0;
    pipe.to = *got;
  }
  const ssize_t put =
      pipe.to == pipe.from ? 0 : ::write(pipe.into.get(), pipe.room.data() + pipe.from, pipe.to - pipe.from);
  if (put > 0) {
    pipe.from += static_cast<std::size_t>(put);
    return true;
  }
  // At the end of the file, or once the child has closed its end, there is nothing left to move.
  if (put == 0 || (errno != EAGAIN && errno != EINTR)) pipe.into = Descriptor();
  return false;
}

}  // namespace plumbline::firmware
