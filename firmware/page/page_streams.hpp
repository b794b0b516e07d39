#pragma once
/// Answers that are sent in parts: server-sent events, and reports of prints.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "firmware/page/http_server.hpp"

namespace plumbline::firmware::inline page {

class PageStreams {
 public:
  using HostClock = std::chrono::steady_clock;

  /// At least this long between two states for one browser.
  static constexpr std::chrono::milliseconds kBetweenEvents{200};
  /// Something is sent at least as often, so that a browser that has gone is noticed.
  static constexpr std::chrono::seconds kSignOfLife{10};

  /// Takes all its memory here.
  PageStreams();

  /// There is a new state, or the printer is gone.
  void tell() { ++event_; }
  /// A place is taken by a new stream.
  void begin(std::size_t place);
  /// Writes the state, if the browser of this place has not got it and had none a moment ago; else a sign of life, if it is time.
  /// @param state  empty: there is no printer
  /// @param lives  it answers
  std::size_t write_event(std::size_t place, std::string_view state, bool lives, std::span<char> out);
  /// A part of a report has come. @returns whether it has any bytes
  bool put_report(std::size_t place, std::string_view base64);
  /// Writes that part. @returns 0: none has come
  std::size_t write_report(std::size_t place, std::span<char> out);

  /// Whether the events are to be woken now.
  bool wakes(HostClock::time_point now);
  /// Whether an event waits for the end of kBetweenEvents.
  bool hurries() const { return event_ != woken_for_ || owes_event_; }

 private:
  struct Stream {
    std::uint64_t told = 0;  ///< number of the last event
    HostClock::time_point told_at;
    std::size_t report_bytes = 0;  ///< of report, that wait to be sent
    std::vector<std::byte> report;
  };

  std::array<Stream, HttpServer::kMostStreams> streams_;
  std::uint64_t event_ = 1;  ///< rises with each state and when the connection ends
  bool owes_event_ = false;  ///< a stream got none yet because it had one a moment ago
  HostClock::time_point woken_{};
  std::uint64_t woken_for_ = 0;
};

}  // namespace plumbline::firmware::inline page
