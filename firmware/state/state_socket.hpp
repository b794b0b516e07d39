#pragma once
/// Serves the printer's state to screens, pages and scripts, and takes their commands: two Unix sockets, README.md has the protocol.
///
///   PATH           whoever is on this machine may read
///   PATH.command   the owner and the group of the file may also command
///
/// There is no thread: serve() is called where the firmware waits for events anyway, and does a bounded amount of work each time.

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "firmware/io/descriptor.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/picture_line.hpp"
#include "firmware/state/printer_record.hpp"
#include "firmware/state/state_client.hpp"
#include "firmware/state/state_line.hpp"
#include "hal/events.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware::inline state {

/// Carries commands out.
class CommandTaker {
 public:
  virtual ~CommandTaker() = default;
  /// @pre takes() says that the printer takes it now
  /// @returns the event that it becomes; none: it is done
  /// @retval ErrorCode::kBadSetting  what is wrong with it
  [[nodiscard]] virtual Expected<std::optional<EventKind>> take(const ClientRequest& request) = 0;

  /// Begins to take a scan into the printer's store.
  /// @param upload  its name and size, as they were sent
  /// @param from    a socket that its bytes come through; may be anything, or not open
  /// @returns the number of PrinterRecord::upload
  /// @retval ErrorCode::kBadSetting  this printer takes none, or not such a one, or not now
  [[nodiscard]] virtual Expected<std::uint32_t> take_upload(const ClientRequest& /*upload*/, Descriptor /*from*/) {
    return fail(ErrorCode::kBadSetting, "no scan can be uploaded");
  }

  /// Draws the mask of a layer of what is offered. Never waits.
  /// @returns false: it is being made. The same is asked again in the next turn
  /// @retval ErrorCode::kBadSetting  nothing is offered that has been sliced, or it has no such layer
  [[nodiscard]] virtual Expected<bool> draw_mask(std::uint32_t /*layer*/, const MaskWindow& /*window*/,
                                                 MaskPicture& /*picture*/) {
    return fail(ErrorCode::kBadSetting, "there are no masks");
  }

  struct ReportPart {
    std::size_t bytes = 0;   ///< of this part
    std::uint64_t size = 0;  ///< of the report, bytes
  };
  /// Reads a part of the last print's report.
  /// @param from  the first byte
  /// @param out   filled from its start
  /// @pre the printer is at rest, so the storage may take its time
  /// @retval ErrorCode::kBadSetting  there is none
  /// @retval ErrorCode::kCannotRead
  [[nodiscard]] virtual Expected<ReportPart> read_report(std::uint64_t /*from*/, std::span<std::byte> /*out*/) {
    return fail(ErrorCode::kBadSetting, "there is no report");
  }
};

/// Times by the host's clock.
struct StateSocketTimes {
  /// Between two turns: a firmware that computes looks for events far more often than a client can tell.
  std::chrono::nanoseconds turn = std::chrono::milliseconds(20);
  /// A stopped terminal or a busy page is forgiven; whoever reads nothing for longer has to connect again.
  std::chrono::nanoseconds patience = std::chrono::seconds(10);
};

class StateSocket {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Readers can't take the places of those who may command.
  static constexpr std::size_t kReaders = 8;
  static constexpr std::size_t kCommanders = 5;  ///< the page takes two

  /// Takes all its memory here. The object is large.
  /// @retval ErrorCode::kCannotOpen  the path, the reason; or another daemon serves there
  [[nodiscard]] static Expected<std::unique_ptr<StateSocket>> open(const std::string& path,
                                                                   const StateSocketTimes& times = {});
  StateSocket(const StateSocket&) = delete;
  StateSocket& operator=(const StateSocket&) = delete;

  /// Sends the record where it has changed and takes at most one command of each client. Never waits. Calls that follow too soon do
  /// nothing.
  /// @returns the event that a command has become
  std::optional<EventKind> serve(const PrinterRecord& record, CommandTaker& taker);

 private:
  struct Door {
    Descriptor listener;
    std::span<StateClient> clients;
    bool may_command = false;
  };

  StateSocket(const StateSocketTimes& times, PictureLine pictures) : times_(times), pictures_(std::move(pictures)) {}
  std::optional<EventKind> serve_all(const PrinterRecord& record, CommandTaker& taker);
  void write_state(const PrinterRecord& record);
  void let_in(Door& door);
  void serve_client(StateClient& client, const Door& door, const PrinterRecord& record, CommandTaker& taker,
                    std::optional<EventKind>& event);
  void answer(StateClient& client, std::optional<std::uint64_t> id, const Error* error);
  Expected<bool> write_answer(std::optional<std::uint64_t> id, const ClientRequest& question,
                              const PrinterRecord& record, CommandTaker& taker);
  Status write_kept(std::optional<std::uint64_t> id, const ClientRequest& question, const PrinterRecord& record);
  Status write_report(std::optional<std::uint64_t> id, std::uint64_t from, CommandTaker& taker);
  Status write_model(std::optional<std::uint64_t> id, std::uint64_t from, const PrinterRecord& record);
  Status write_part(std::optional<std::uint64_t> id, std::uint64_t from, std::uint64_t size,
                    std::span<const std::byte> bytes, std::string_view of = "");

  StateSocketTimes times_;
  std::array<StateClient, kReaders + kCommanders> clients_;
  std::array<Door, 2> doors_;
  PictureLine pictures_;
  StateLine line_;  ///< the newest state
  StateLine next_;  ///< scratch
  StateLine reply_;
  std::uint64_t sequence_ = 0;  ///< of line_
  HostClock::time_point now_;
  HostClock::time_point served_at_;
};

}  // namespace plumbline::firmware::inline state
