#include "firmware/daemon/stick/scan_feed.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace plumbline {

Expected<int> ScanFeed::open() {
  if (const auto file = file_.descriptor()) return *file;
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return fail(ErrorCode::kCannotRead, "no pipe: %s", std::strerror(errno));
  ours_ = Descriptor(ends[0]);
  into_ = Descriptor(ends[1]);
  if (::fcntl(into_.get(), F_SETFL, O_NONBLOCK) != 0) {
    return fail(ErrorCode::kCannotRead, "no pipe: %s", std::strerror(errno));
  }
  return ours_.get();
}

Expected<bool> ScanFeed::pump() {
  if (!into_.is_open()) return false;
  if (from_ == to_) {
    const auto got = file_.read(bytes_);
    PLUMBLINE_TRY(got);
    from_ = 0;
    to_ = *got;
  }
  const ssize_t put = to_ == from_ ? 0 : ::write(into_.get(), bytes_.data() + from_, to_ - from_);
  if (put > 0) {
    from_ += static_cast<std::size_t>(put);
    return true;
  }
  // At the end of the file, or once the child has closed its end, there is nothing left to move.
  if (put == 0 || (errno != EAGAIN && errno != EINTR)) into_ = Descriptor();
  return false;
}

}  // namespace plumbline
