#pragma once
/// The printer's screen as one more client of its state: draws the record, and turns buttons and touches into what they mean on the screen
/// at hand.

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/canvas/qr_code.hpp"
#include "firmware/screen/kept_preview.hpp"
#include "firmware/screen/look.hpp"
#include "firmware/screen/screen_view.hpp"
#include "firmware/state/state_socket.hpp"
#include "hal/events.hpp"
#include "hal/status_screen.hpp"

namespace plumbline::firmware::inline screen {

class ScreenServer {
 public:
  using HostClock = std::chrono::steady_clock;

  /// Between two frames. People see no more, and a board has better things to do.
  static constexpr std::chrono::milliseconds kTurn{200};
  /// A wait that ends sooner gets no frame. The slowest one takes 2 ms for 1024 x 600 pixels on a core of x86-64; this leaves a board room.
  static constexpr nanoseconds kSpare = std::chrono::milliseconds(100);
  /// A press this soon after a question was not meant for it.
  static constexpr nanoseconds kSettle = std::chrono::seconds(1);

  /// Takes all its memory here.
  /// @param screen  must outlive it; at least kLeastColumns x kLeastRows
  ScreenServer(StatusScreen& screen, Language language);

  /// Shows the record, if it has changed and the last frame is long enough ago. A screen that fails is tried again with the next frame.
  /// @param spare  time until something is due: while the printer prints, a frame is drawn only if it is over before
  void show(const PrinterRecord& record, nanoseconds spare);

  /// What an event is on the screen at hand.
  /// @returns the event that the printer gets; none: the screen took it
  std::optional<Event> filter(const Event& event, const PrinterRecord& record, CommandTaker& taker);
  /// What somebody has touched. @returns the event that it becomes
  std::optional<Event> touched(const PrinterRecord& record, CommandTaker& taker);

  const ScreenView& view() const { return view_; }
  std::uint32_t frames() const { return frames_; }

 private:
  std::optional<Event> act(ButtonAct act, const PrinterRecord& record, CommandTaker& taker, TimePoint at);
  std::optional<std::size_t> touched_remedy(const ScreenTouch& touch, const PrinterRecord& record) const;
  void choose_next(const PrinterRecord& record, CommandTaker& taker);

  StatusScreen& screen_;
  Language language_;
  Look look_;
  std::vector<Colour> shown_, next_;
  Expected<KeptPreview> kept_preview_;  ///< an error: kept prints are listed without a picture
  FixedText<96> coded_;                 ///< what address_code_ says
  QrCode address_code_;
  ScreenView view_;
  TimePoint asked_at_;
  std::uint64_t drawn_question_ = 0;  ///< PrinterRecord::question_id() when the screen was drawn last
  HostClock::time_point drawn_at_{};
  std::uint32_t frames_ = 0;
};

}  // namespace plumbline::firmware::inline screen
