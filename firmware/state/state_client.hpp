#pragma once
/// One connection of the state socket. Never waits: what the client does not take at once is kept, up to a bound. A client that takes
/// nothing for long, or that is owed more than the bound, is dropped.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "firmware/io/descriptor.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/state_line.hpp"

namespace plumbline::firmware::inline state {

class StateClient {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Whether whoever was at the other end of a socket has closed it, and so gets no answer. An end that is only shut down for sending has not.
  static bool has_gone(const Descriptor& socket);

  bool is_open() const { return socket_.is_open(); }
  bool has_gone() const { return has_gone(socket_); }
  /// @param may_hand_over  descriptors that come with its bytes are taken: see handed_over()
  void open(Descriptor socket, bool may_hand_over = false);
  void drop();

  /// Sends what is owed.
  /// @param patience  a client that has taken nothing for longer is dropped
  /// @returns whether nothing is owed any more
  bool flush(HostClock::time_point now, HostClock::duration patience);
  /// Sends a line, or keeps what of it could not be sent.
  void send(std::string_view line);
  /// Sends a state line, unless the client has it or is owed another one.
  void send_state(std::string_view line, std::uint64_t sequence);

  /// Receives what is there. @returns the oldest line that has not been taken, without its end; none: it has not all come yet.
  /// Valid until take_line().
  std::optional<std::string_view> line();
  void take_line();
  /// The newest descriptor that came with the client's bytes (SCM_RIGHTS), and is not the client's any more; it may be anything. Not open:
  /// none came.
  Descriptor handed_over() { return std::exchange(handed_, Descriptor()); }
  /// More than kLongestRequest bytes have come without the end of a line.
  bool is_flooding() const { return filled_ == in_.size() && line_size_ == 0; }
  /// The client sends nothing more, and all that it asked for is answered.
  bool is_done() const { return ended_ && owed_ == 0 && line_size_ == 0; }

 private:
  void receive();
  ssize_t receive_with_descriptors();

  Descriptor socket_;
  bool may_hand_over_ = false;
  Descriptor handed_;
  bool ended_ = false;         ///< the client has closed its end for sending
  std::uint64_t sent_ = 0;     ///< sequence of the last state line
  std::size_t filled_ = 0;     ///< of in_
  std::size_t line_size_ = 0;  ///< of the first line in in_, its end included; 0: it has not all come
  std::size_t sent_of_out_ = 0;
  std::size_t owed_ = 0;               ///< bytes of out_, from sent_of_out_ on
  HostClock::time_point stuck_since_;  ///< while something is owed: when the client last took a byte
  std::array<char, kLongestRequest + 1> in_{};
  std::array<char, kLongestLine> out_{};
};

}  // namespace plumbline::firmware::inline state
