#include "firmware/screen/screens.hpp"

#include "firmware/screen/screen_kind.hpp"
#include "firmware/screen/screen_parts.hpp"

namespace plumbline::firmware::inline screen {
namespace {

void draw_kind(const Sheet& sheet) {
  if (sheet.view.asks_to_cancel) return draw_cancel_question(sheet);
  if (sheet.view.asks_to_remove) return draw_remove_question(sheet);
  if (sheet.view.lights_open) return draw_light_card(sheet);
  if (sheet.view.proposals_open && sheet.record.proposals) return draw_proposals(sheet);
  switch (screen_of(sheet.record)) {
    case ScreenKind::kIdle: return sheet.view.prints_open ? draw_prints(sheet) : draw_idle(sheet);
    case ScreenKind::kScans: return sheet.view.settings_open ? draw_settings(sheet) : draw_scans(sheet);
    case ScreenKind::kPreview:
      if (sheet.view.remedies_open) return draw_remedies(sheet);
      return sheet.view.contract_open ? draw_contract(sheet) : draw_preview_screen(sheet);
    case ScreenKind::kSlicing: return draw_slicing(sheet);
    case ScreenKind::kChecks: return draw_checks(sheet);
    case ScreenKind::kPrinting: return draw_printing(sheet);
    case ScreenKind::kPause: return draw_pause(sheet);
    case ScreenKind::kRaising: return draw_raising(sheet);
    case ScreenKind::kPlate: return draw_plate(sheet);
    case ScreenKind::kInterrupted: return draw_interrupted(sheet);
    case ScreenKind::kFault: return draw_fault(sheet);
    case ScreenKind::kEnding: return draw_ending(sheet);
  }
}

}  // namespace

std::optional<std::uint32_t> preview_wanted(const PrinterRecord& record, const ScreenView& view) {
  if (!view.prints_open) return std::nullopt;
  return record.prints->list()[view.print].number;
}

void draw_screen(Page& page, const PrinterRecord& record, const ScreenView& view, Language language,
                 const PreviewPicture* kept_preview, const QrCode* address_code) {
  const Sheet sheet{page, record, view, language, kept_preview, address_code};
  draw_kind(sheet);
  draw_buttons(sheet);
}

}  // namespace plumbline::firmware::inline screen
