#pragma once
/// The page's connection to the printer's state socket. Never waits for the printer, and connects again when it has come back.

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/io/descriptor.hpp"

namespace plumbline::firmware::inline page {

class PrinterLink {
 public:
  using HostClock = std::chrono::steady_clock;

  static constexpr std::chrono::seconds kBetweenTries{1};

  /// @param path  of the socket for commands
  explicit PrinterLink(std::string path);

  bool is_open() const { return socket_.is_open(); }
  int descriptor() const { return socket_.get(); }

  /// Connects, if there is no connection and the last try is long enough ago.
  void connect(HostClock::time_point now);
  /// Receives what is there. Ends the connection if the printer has.
  void receive();
  /// @returns the oldest line that has not been taken, without its end; valid until receive(). None: it has not all come yet
  std::optional<std::string_view> take_line();
  /// Ends the connection. The printer carries out nothing that it has not taken yet.
  void end();
  /// Ends the connection if the printer does not take the line at once.
  /// @param file  a descriptor that the printer gets a copy of; below 0: none
  /// @returns whether it was sent
  bool send(std::string_view line, int file = -1);

 private:
  std::string path_;
  Descriptor socket_;
  HostClock::time_point tried_at_{};
  std::vector<char> bytes_;             ///< room for two lines
  std::size_t taken_ = 0, filled_ = 0;  ///< of bytes_
};

}  // namespace plumbline::firmware::inline page
