#pragma once
/// Draws the printer's screens. Each shows only what the state socket's record says, and the preview of a kept print.

#include "firmware/canvas/qr_code.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/pictures/job_pictures.hpp"
#include "firmware/screen/page.hpp"
#include "firmware/screen/screen_view.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline::firmware::inline screen {

/// Draws the whole screen of the printer's state, with what people have opened on it.
/// @param view          by still_open()
/// @param kept_preview  of the print that preview_wanted() names; nullptr: there is none
/// @param address_code  of the record's address; nullptr: there is none
void draw_screen(Page& page, const PrinterRecord& record, const ScreenView& view, Language language,
                 const PreviewPicture* kept_preview, const QrCode* address_code);

/// The kept print whose preview the screen shows. @returns nothing: it shows none
std::optional<std::uint32_t> preview_wanted(const PrinterRecord& record, const ScreenView& view);

}  // namespace plumbline::firmware::inline screen
