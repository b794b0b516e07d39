#pragma once
/// Draws the printer's screens. Each shows only what the state socket's record says.

#include "firmware/screen/page.hpp"
#include "firmware/screen/screen_view.hpp"
#include "firmware/screen/words.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline {

/// Draws the whole screen of the printer's state, with what people have opened on it.
/// @param view  by still_open()
void draw_screen(Page& page, const PrinterRecord& record, const ScreenView& view, Language language);

}  // namespace plumbline
