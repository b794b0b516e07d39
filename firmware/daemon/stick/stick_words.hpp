#pragma once

#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/words/told.hpp"

namespace plumbline {

/// Rewrites advice that names options of the command line into keys of job.toml, which a printer's user has instead:
/// "Use --scale 0.5 or less, --fit" becomes "Use scale = 0.5 or less, fit = true (in job.toml on the stick)". Text without such
/// options stays as it is.
FixedText<1000> in_stick_words(std::string_view text);

/// The same, for what the printer's settings can change: names them first, since they need no computer.
FixedText<1000> in_stick_words(std::string_view text, ToldCode told);

}  // namespace plumbline
