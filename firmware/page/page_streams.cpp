#include "firmware/page/page_streams.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "firmware/io/text/base64.hpp"
#include "firmware/state/state_line.hpp"

namespace plumbline::firmware::inline page {

PageStreams::PageStreams() {
  for (Stream& stream : streams_) stream.report.resize(kLongestLine / 4 * 3);
}

void PageStreams::begin(std::size_t place) {
  streams_[place].told = 0;
  streams_[place].told_at = {};
  streams_[place].report_bytes = 0;
}

std::size_t PageStreams::write_event(std::size_t place, std::string_view state, bool lives, std::span<char> out) {
  Stream& stream = streams_[place];
  const auto now = HostClock::now();
  std::string_view parts[] = {":", "", "\n\n"};  // a comment: a sign of life
  if (stream.told != event_) {
    if (now - stream.told_at < kBetweenEvents) {
      owes_event_ = true;
      return 0;
    }
    parts[0] = state.empty() ? "event: lost\ndata: " : lives ? "data: " : "event: hangs\ndata: ";
    parts[1] = lives ? state : std::string_view();
  } else if (now - stream.told_at < kSignOfLife) {
    return 0;
  }
  std::size_t size = 0;
  for (const std::string_view part : parts) {
    part.copy(out.data() + size, part.size());
    size += part.size();
  }
  stream.told = event_;
  stream.told_at = now;
  return size;
}

bool PageStreams::put_report(std::size_t place, std::string_view base64) {
  streams_[place].report_bytes = read_base64(base64, streams_[place].report).value_or(0);
  return streams_[place].report_bytes > 0;
}

std::size_t PageStreams::write_report(std::size_t place, std::span<char> out) {
  Stream& stream = streams_[place];
  const std::size_t size = std::min(out.size(), std::exchange(stream.report_bytes, 0));
  std::memcpy(out.data(), stream.report.data(), size);
  return size;
}

bool PageStreams::wakes(HostClock::time_point now) {
  if (now - woken_ < (hurries() ? kBetweenEvents : HostClock::duration(kSignOfLife))) return false;
  woken_ = now;
  woken_for_ = event_;
  owes_event_ = false;
  return true;
}

}  // namespace plumbline::firmware::inline page
