#include "firmware/screen/screen_view.hpp"

#include <algorithm>

#include "firmware/screen/screen_kind.hpp"
#include "firmware/screen/setting_rows.hpp"

namespace plumbline::firmware::inline screen {
namespace {

using Uses = std::array<std::optional<ButtonUse>, kScreenButtonCount>;

/// A part hangs on the plate, or is about to.
bool loses_a_part(PrintState state) { return state == PrintState::kPrinting || is_pause(state); }

std::size_t kept_prints(const PrinterRecord& record) {
  return record.prints != nullptr ? record.prints->list().size() : 0;
}

Uses uses_on_scans(const PrinterRecord& record, const ScreenView& view) {
  if (view.proposals_open) {
    return {ButtonUse{Words::kDoTake, ButtonAct::kTakeProposal}, ButtonUse{Words::kDoNext, ButtonAct::kNextProposal},
            ButtonUse{Words::kDoBack, ButtonAct::kCloseProposals}};
  }
  if (view.settings_open && opens_proposals(view.setting)) {
    return {ButtonUse{Words::kDoOpen, ButtonAct::kOpenProposals}, ButtonUse{Words::kDoNext, ButtonAct::kNextSetting},
            ButtonUse{Words::kDoBack, ButtonAct::kCloseSettings}};
  }
  if (view.settings_open) {
    return {ButtonUse{Words::kDoChange, ButtonAct::kChangeSetting}, ButtonUse{Words::kDoNext, ButtonAct::kNextSetting},
            ButtonUse{Words::kDoBack, ButtonAct::kCloseSettings}};
  }
  Uses uses;
  switch (view.row) {
    case ListRow::kScan: uses[0] = ButtonUse{Words::kDoPrint}; break;
    case ListRow::kFolder:
    case ListRow::kUp: uses[0] = ButtonUse{Words::kDoOpen, ButtonAct::kOpenFolder}; break;
    case ListRow::kSettings: uses[0] = ButtonUse{Words::kDoOpen, ButtonAct::kOpenSettings}; break;
    case ListRow::kRemove: uses[0] = ButtonUse{Words::kDoDelete, ButtonAct::kAskToRemove}; break;
  }
  uses[1] = ButtonUse{Words::kDoNext, ButtonAct::kNextScan};
  if (takes(record, Command::kCancel)) uses[2] = ButtonUse{Words::kDoDecline};
  return uses;
}

/// Leaves the finding at hand: for the next one, or for the values of the print.
ButtonUse past_finding(const PrinterRecord& record, const ScreenView& view) {
  return view.finding + 1 < record.finding_count ? ButtonUse{Words::kDoMore, ButtonAct::kMoreFindings}
                                                 : ButtonUse{Words::kDoChange, ButtonAct::kOpenContract};
}

Uses uses_on_remedies(const PrinterRecord& record, const ScreenView& view) {
  const bool is_last = view.remedy + 1 == remedy_rows(record, view);
  return {is_last ? ButtonUse{Words::kDoOpen, past_finding(record, view).act}
                  : ButtonUse{Words::kDoTake, ButtonAct::kTakeRemedy},
          ButtonUse{Words::kDoNext, ButtonAct::kNextRemedy}, ButtonUse{Words::kDoBack, ButtonAct::kCloseRemedies}};
}

/// Goes through the values, and back behind the last one.
Uses uses_on_contract(const ScreenView& view) {
  const bool last = view.value + 1 == kContractRows;
  Uses uses = {std::nullopt, std::nullopt, ButtonUse{last ? Words::kDoBack : Words::kDoNext, ButtonAct::kNextValue}};
  if (view.value == 0) {
    uses[0] = ButtonUse{Words::kDoOpen, ButtonAct::kGoBack};
  } else if (kPrintFields[view.value - 1].can_be_changed()) {
    uses[0] = ButtonUse{Words::kDoRaise, ButtonAct::kRaiseValue};
    uses[1] = ButtonUse{Words::kDoLower, ButtonAct::kLowerValue};
  }
  return uses;
}

/// The screens from which the card can be opened: nobody is in a hurry there.
bool has_light_card(ScreenKind kind) { return kind == ScreenKind::kIdle || kind == ScreenKind::kPlate; }

constexpr ButtonUse kOpenCard{Words::kDoLights, ButtonAct::kOpenLights};

}  // namespace

std::size_t first_contract_row(const PrinterRecord& record) { return takes(record, Command::kSettings) ? 0 : 1; }

std::size_t remedy_rows(const PrinterRecord& record, const ScreenView& view) {
  if (view.finding >= record.finding_count || !takes(record, Command::kSettings)) return 0;
  const std::size_t remedies = record.findings[view.finding].remedies.count;
  return remedies > 0 ? remedies + 1 : 0;
}

std::size_t rows_of(ListRow row, const PrinterRecord& record) {
  switch (row) {
    case ListRow::kScan: return record.has_job_file ? 1 : record.scan_count;
    case ListRow::kFolder: return takes(record, Command::kOpen) ? record.folder_count : 0;
    case ListRow::kUp: return takes(record, Command::kOpen) && !record.folder.view().empty() ? 1 : 0;
    case ListRow::kSettings: return 1;
    case ListRow::kRemove: return record.scans_uploaded && takes(record, Command::kRemove) ? 1 : 0;
  }
  return 0;
}

std::size_t row_at(const PrinterRecord& record, const ScreenView& view) {
  if (view.row == ListRow::kScan) return record.job && record.job->chosen ? *record.job->chosen : 0;
  std::size_t at = view.row == ListRow::kFolder ? view.folder : 0;
  for (ListRow row = ListRow::kScan; row != view.row; row = static_cast<ListRow>(static_cast<int>(row) + 1)) {
    at += rows_of(row, record);
  }
  return at;
}

Uses buttons_of(const PrinterRecord& record, const ScreenView& view) {
  Uses uses;
  const auto give = [&](ScreenButton button, Command command, Words label, ButtonAct act = ButtonAct::kCommand) {
    if (takes(record, command)) uses[static_cast<std::size_t>(button)] = ButtonUse{label, act};
  };
  using enum ScreenButton;
  if (view.asks_to_cancel) {
    return {ButtonUse{Words::kDoKeepPrinting, ButtonAct::kKeep}, std::nullopt, ButtonUse{Words::kDoEndPrint}};
  }
  if (view.asks_to_remove) {
    return {ButtonUse{Words::kDoBack, ButtonAct::kKeep}, std::nullopt, ButtonUse{Words::kDoDelete, ButtonAct::kRemove}};
  }
  if (view.lights_open) {
    return {std::nullopt, ButtonUse{Words::kDoNext, ButtonAct::kNextPattern},
            ButtonUse{Words::kDoBack, ButtonAct::kCloseLights}};
  }
  const ButtonAct ask = loses_a_part(record.state) ? ButtonAct::kAskToCancel : ButtonAct::kCommand;
  switch (screen_of(record)) {
    case ScreenKind::kIdle:
      if (view.prints_open) {
        if (kept_prints(record) > 1) uses[1] = ButtonUse{Words::kDoNext, ButtonAct::kNextPrint};
        uses[2] = ButtonUse{Words::kDoBack, ButtonAct::kClosePrints};
        break;
      }
      give(kStart, Command::kOffer, Words::kDoOffer);
      if (kept_prints(record) > 0) uses[1] = ButtonUse{Words::kDoPrints, ButtonAct::kOpenPrints};
      uses[2] = kOpenCard;
      break;
    case ScreenKind::kScans:
      if (record.job && takes(record, Command::kStart)) return uses_on_scans(record, view);
      break;
    case ScreenKind::kPreview:
      give(kStart, Command::kStart, Words::kDoPrint);
      if (view.contract_open) return uses_on_contract(view);
      if (view.remedies_open) return uses_on_remedies(record, view);
      uses[1] = remedy_rows(record, view) > 0 ? ButtonUse{Words::kDoMend, ButtonAct::kOpenRemedies}
                                              : past_finding(record, view);
      give(kCancel, Command::kCancel, Words::kDoDecline);
      break;
    case ScreenKind::kSlicing: give(kCancel, Command::kCancel, Words::kDoStop); break;
    case ScreenKind::kChecks:
    case ScreenKind::kPrinting:
      give(kPause, Command::kPause, Words::kDoPause);
      give(kCancel, Command::kCancel, Words::kDoCancel, ask);
      break;
    case ScreenKind::kPause:
      give(kStart, Command::kResume, Words::kDoResume);
      give(kPause, Command::kPause, Words::kDoPause);
      give(kCancel, Command::kCancel, Words::kDoCancel, ask);
      break;
    case ScreenKind::kPlate:
      give(kStart, Command::kPlateEmpty, Words::kDoEmpty);
      uses[2] = kOpenCard;
      break;
    case ScreenKind::kInterrupted:
      give(kStart, Command::kResume, Words::kDoResume);
      give(kCancel, Command::kCancel, Words::kDoGiveUp);
      break;
    case ScreenKind::kFault: give(kStart, Command::kSeen, Words::kDoSeen); break;
    case ScreenKind::kRaising:
    case ScreenKind::kEnding: break;
  }
  return uses;
}

ScreenView still_open(const PrinterRecord& record, ScreenView view) {
  const ScreenKind kind = screen_of(record);
  const bool proposing = record.slicing && record.slicing->proposes;
  view.proposals_open = view.proposals_open && (proposing || (kind == ScreenKind::kScans && record.proposals));
  if (!view.proposals_open) view.proposal = 0;
  const bool gone = view.folder >= rows_of(view.row, record) && view.row != ListRow::kScan;
  if ((kind != ScreenKind::kScans && !proposing) || (gone && !proposing)) {
    view.row = ListRow::kScan;
    view.folder = 0;
    view.settings_open = false;
  }
  view.asks_to_remove = view.asks_to_remove && view.row == ListRow::kRemove;
  if (!view.settings_open || !record.job || view.setting >= setting_rows(record)) view.setting = 0;
  view.contract_open = view.contract_open && kind == ScreenKind::kPreview;
  view.value = view.contract_open ? std::max(view.value, first_contract_row(record)) : 0;
  if (kind != ScreenKind::kPreview || view.finding >= record.finding_count) view.finding = 0;
  const std::size_t remedies = kind == ScreenKind::kPreview && !view.contract_open ? remedy_rows(record, view) : 0;
  view.remedies_open = view.remedies_open && remedies > 0;
  if (!view.remedies_open || view.remedy >= remedies) view.remedy = 0;
  view.prints_open = view.prints_open && kind == ScreenKind::kIdle && kept_prints(record) > 0;
  if (!view.prints_open || view.print >= kept_prints(record)) view.print = 0;
  view.lights_open = view.lights_open && has_light_card(kind);
  if (!view.lights_open) view.pattern = 0;
  view.asks_to_cancel =
      view.asks_to_cancel && view.job == record.job_id && loses_a_part(record.state) && takes(record, Command::kCancel);
  return view;
}

}  // namespace plumbline::firmware::inline screen
