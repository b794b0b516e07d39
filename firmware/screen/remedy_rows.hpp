#pragma once
/// What mends the finding at hand: a row each, and a last one that leaves the finding as it is.

#include <cstddef>

#include "firmware/canvas/canvas.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/screen/look.hpp"
#include "firmware/screen/screen_view.hpp"
#include "firmware/state/client_request.hpp"
#include "firmware/state/printer_record.hpp"

namespace plumbline::firmware::inline screen {

/// The setting of a row: "Add supports", "It is in cm", "Make the height 40.15 mm".
FixedText<96> remedy_text(const Remedy& remedy, Language language);

/// The request that carries a remedy out. The printer slices anew.
ClientRequest remedy_request(const Remedy& remedy);

/// Where a row is, between title and buttons. As high as fingers need, if the finding above leaves room.
/// @param all   the screen
/// @param rows  remedy_rows()
PixelBox remedy_row_box(const Look& look, const PixelBox& all, std::size_t rows, std::size_t row);

}  // namespace plumbline::firmware::inline screen
