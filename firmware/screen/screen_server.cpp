#include "firmware/screen/screen_server.hpp"

#include <algorithm>
#include <utility>

#include "firmware/screen/light_card.hpp"
#include "firmware/screen/remedy_rows.hpp"
#include "firmware/screen/screens.hpp"
#include "firmware/screen/setting_rows.hpp"

namespace plumbline::firmware::inline screen {
namespace {

std::optional<ScreenButton> button_of_event(EventKind kind) {
  switch (kind) {
    case EventKind::kStartPressed: return ScreenButton::kStart;
    case EventKind::kPausePressed: return ScreenButton::kPause;
    case EventKind::kCancelPressed: return ScreenButton::kCancel;
    case EventKind::kCoverOpened:
    case EventKind::kCoverClosed:
    case EventKind::kStickArrived:
    case EventKind::kStickDeparted:
    case EventKind::kExposureEnded:
    case EventKind::kMotionEnded:
    case EventKind::kShutdownRequested: return std::nullopt;
  }
  return std::nullopt;
}

/// By ScreenButton.
constexpr std::array kEvents = {EventKind::kStartPressed, EventKind::kPausePressed, EventKind::kCancelPressed};

/// @returns the event that a request has become. A value that the printer refuses stays as it was: the screen shows the record's
std::optional<Event> ask(CommandTaker& taker, const ClientRequest& request, TimePoint at) {
  const auto taken = taker.take(request);
  if (!taken || !*taken) return std::nullopt;
  return Event{at, **taken, true};
}

}  // namespace

ScreenServer::ScreenServer(StatusScreen& screen, Language language)
    : screen_(screen),
      language_(language),
      look_(static_cast<int>(screen.columns()), static_cast<int>(screen.rows())),
      shown_(std::size_t{screen.columns()} * screen.rows()),
      next_(shown_.size()),
      kept_preview_(KeptPreview::create()) {}

void ScreenServer::show(const PrinterRecord& record, nanoseconds spare) {
  if (record.state == PrintState::kPrinting && spare < kSpare) return;
  if (HostClock::now() - drawn_at_ < kTurn) return;
  view_ = still_open(record, view_);
  Canvas canvas(next_, static_cast<int>(screen_.columns()), static_cast<int>(screen_.rows()));
  Page page(canvas, look_);
  const auto wanted = preview_wanted(record, view_);
  const bool can_show = wanted && kept_preview_;
  // Only at rest: making a code takes memory from the heap, and gives it back.
  if (record.state == PrintState::kIdle && coded_.view() != record.address.view()) {
    coded_ = record.address;
    address_code_ = QrCode(coded_.view());
  }
  draw_screen(page, record, view_, language_, can_show ? kept_preview_->of(*record.prints, *wanted) : nullptr,
              &address_code_);
  if (frames_ == 0 || next_ != shown_) {
    if (screen_.present(next_)) {
      std::swap(next_, shown_);
      ++frames_;
    }
  }
  drawn_at_ = HostClock::now();
  drawn_question_ = record.question_id();
}

std::optional<Event> ScreenServer::filter(const Event& event, const PrinterRecord& record, CommandTaker& taker) {
  const auto button = button_of_event(event.kind);
  if (!button) return event;
  view_ = still_open(record, view_);
  drawn_at_ = {};  // whoever presses a button sees at once what it did
  const bool asks = view_.asks_to_cancel || view_.asks_to_remove;
  if (asks && event.at < asked_at_ + kSettle) return std::nullopt;
  // Whoever pressed it saw the question before. The screen has the new one in a moment.
  if (record.question_id() != 0 && record.question_id() != drawn_question_ && frames_ > 0) return std::nullopt;
  const auto use = buttons_of(record, view_)[static_cast<std::size_t>(*button)];
  if (!use) {
    const bool opened = asks || view_.settings_open || view_.contract_open || view_.remedies_open ||
                        view_.prints_open || view_.lights_open;
    return opened ? std::nullopt : std::optional(event);
  }
  if (use->act == ButtonAct::kCommand) {
    view_.asks_to_cancel = false;
    return event;
  }
  return act(use->act, record, taker, event.at);
}

std::optional<Event> ScreenServer::touched(const PrinterRecord& record, CommandTaker& taker) {
  const auto touch = screen_.next_touch();
  if (!touch) return std::nullopt;
  if (touch->column >= screen_.columns()) return std::nullopt;
  if (const auto row = touched_remedy(*touch, record)) {
    view_.remedy = *row;
    return filter({touch->at, EventKind::kStartPressed}, record, taker);
  }
  const int top = static_cast<int>(screen_.rows()) - look_.px(kButtonRows);
  if (static_cast<int>(touch->row) < top) return std::nullopt;
  const std::size_t third = std::size_t{3} * touch->column / screen_.columns();
  return filter({touch->at, kEvents[third]}, record, taker);
}

/// @returns the row of the list of remedies that is there; none: that is not open
std::optional<std::size_t> ScreenServer::touched_remedy(const ScreenTouch& touch, const PrinterRecord& record) const {
  if (!view_.remedies_open) return std::nullopt;
  const PixelBox all{0, 0, static_cast<int>(screen_.columns()), static_cast<int>(screen_.rows())};
  const std::size_t rows = remedy_rows(record, view_);
  for (std::size_t i = 0; i < rows; ++i) {
    const PixelBox box = remedy_row_box(look_, all, rows, i);
    const int y = static_cast<int>(touch.row) - box.y;
    if (y >= 0 && y < box.height) return i;
  }
  return std::nullopt;
}

/// @returns the event that a command has become
std::optional<Event> ScreenServer::act(ButtonAct act, const PrinterRecord& record, CommandTaker& taker, TimePoint at) {
  switch (act) {
    case ButtonAct::kCommand: break;
    case ButtonAct::kNextScan: choose_next(record, taker); break;
    case ButtonAct::kOpenFolder: {
      ClientRequest request;
      request.command = Command::kOpen;
      request.folder = view_.row == ListRow::kUp ? 0 : static_cast<std::uint32_t>(view_.folder) + 1;
      view_.row = ListRow::kScan;
      view_.folder = 0;
      return ask(taker, request, at);
    }
    case ButtonAct::kOpenSettings: view_.settings_open = true; break;
    case ButtonAct::kCloseSettings: view_.settings_open = false; break;
    case ButtonAct::kNextSetting: view_.setting = (view_.setting + 1) % setting_rows(record); break;
    case ButtonAct::kChangeSetting: return ask(taker, next_value(view_.setting, record, *record.job), at);
    case ButtonAct::kOpenProposals: {
      view_.proposals_open = true;
      view_.proposal = record.proposal().value_or(1);
      if (record.proposals) break;
      ClientRequest request;
      request.command = Command::kPropose;
      return ask(taker, request, at);
    }
    case ButtonAct::kNextProposal: view_.proposal = (view_.proposal + 1) % kProposalCount; break;
    case ButtonAct::kTakeProposal: {
      ClientRequest request;
      request.command = Command::kSet;
      request.key.add("proposal");
      request.value.add("%zu", view_.proposal);
      static_cast<void>(taker.take(request));
      view_.proposals_open = false;
      break;
    }
    case ButtonAct::kCloseProposals: view_.proposals_open = false; break;
    case ButtonAct::kMoreFindings:
      ++view_.finding;
      view_.remedies_open = false;
      break;
    case ButtonAct::kOpenRemedies: view_.remedies_open = true; break;
    case ButtonAct::kNextRemedy: view_.remedy = (view_.remedy + 1) % remedy_rows(record, view_); break;
    case ButtonAct::kTakeRemedy: {
      const Remedy& remedy = record.findings[view_.finding].remedies.list[view_.remedy];
      view_.remedies_open = false;
      return ask(taker, remedy_request(remedy), at);
    }
    case ButtonAct::kCloseRemedies: view_.remedies_open = false; break;
    case ButtonAct::kOpenContract:
      view_.contract_open = true;
      view_.remedies_open = false;
      break;
    case ButtonAct::kGoBack: {
      ClientRequest request;
      request.command = Command::kSettings;
      view_.contract_open = false;
      view_.row = ListRow::kSettings;
      view_.settings_open = true;
      return ask(taker, request, at);
    }
    case ButtonAct::kRaiseValue:
    case ButtonAct::kLowerValue:
      // Another exposure may need other layers: then the question is over.
      return ask(taker, changed_value(view_.value - 1, *record.sliced, act == ButtonAct::kRaiseValue), at);
    case ButtonAct::kNextValue:
      view_.contract_open = view_.value + 1 < kContractRows;
      view_.value = view_.contract_open ? view_.value + 1 : 0;
      view_.finding = 0;
      break;
    case ButtonAct::kAskToCancel:
      view_.asks_to_cancel = true;
      view_.job = record.job_id;
      asked_at_ = at;
      break;
    case ButtonAct::kAskToRemove:
      view_.asks_to_remove = true;
      asked_at_ = at;
      break;
    case ButtonAct::kRemove: {
      view_.asks_to_remove = false;
      ClientRequest request;
      request.command = Command::kRemove;
      request.name.add("%s", record.stored->name.c_str());
      return ask(taker, request, at);
    }
    case ButtonAct::kKeep: view_.asks_to_cancel = view_.asks_to_remove = false; break;
    case ButtonAct::kOpenPrints: view_.prints_open = true; break;
    case ButtonAct::kNextPrint: view_.print = (view_.print + 1) % record.prints->list().size(); break;
    case ButtonAct::kClosePrints: view_.prints_open = false; break;
    case ButtonAct::kOpenLights:
      view_.lights_open = true;
      view_.pattern = light_pattern_of(record.state);
      break;
    case ButtonAct::kNextPattern: view_.pattern = (view_.pattern + 1) % kLightPatternCount; break;
    case ButtonAct::kCloseLights: view_.lights_open = false; break;
  }
  return std::nullopt;
}

/// Goes round the scans and, behind the last one, the other rows.
void ScreenServer::choose_next(const PrinterRecord& record, CommandTaker& taker) {
  const bool several = takes(record, Command::kChoose);
  std::size_t scan = record.job->chosen.value_or(0) + 1;
  if (view_.row == ListRow::kFolder && view_.folder + 1 < rows_of(view_.row, record)) {
    ++view_.folder;
    return;
  }
  if (view_.row != ListRow::kScan || !several || scan == record.scan_count) {
    do {
      view_.row =
          view_.row == ListRow::kRemove ? ListRow::kScan : static_cast<ListRow>(static_cast<int>(view_.row) + 1);
    } while (rows_of(view_.row, record) == 0);
    view_.folder = 0;
    scan = 0;
  }
  if (view_.row != ListRow::kScan || !several) return;
  ClientRequest request;
  request.command = Command::kChoose;
  request.scan = static_cast<std::uint32_t>(scan) + 1;
  static_cast<void>(taker.take(request));
}

}  // namespace plumbline::firmware::inline screen
