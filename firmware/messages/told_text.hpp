#pragma once
/// The printer's messages as sentences in a language: the texts of told_words.hpp with their values filled in.

#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/catalogue.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/error.hpp"

namespace plumbline::firmware {

using ToldText = FixedText<512>;
/// Fills a message's values into a text of the table, formatted as the language does.
ToldText filled_in(std::string_view pattern, const Told& told, Language language);

/// "3 Inseln bis 113 mm² bei x 34,2, y 61,0 mm, Schicht 702 (35,10 mm). Stützen setzen oder das Objekt drehen."
/// @param english  what it is called if there is nothing in the table
ToldText worded(const Told& told, Language language, std::string_view english);

using Advised = FixedText<1000>;
/// An English sentence with what to do about it: with options of the command line, or with the printer's settings and job.toml.
Advised at_terminal(const Told& told, std::string_view sentence);
Advised at_printer(const Told& told, std::string_view sentence);
/// What to do at the printer: that of the code, or else `advice` as it is.
ToldText printer_remedy(const Told& told, std::string_view advice);
/// The error's message, with options of the command line.
Advised at_terminal(const Error& error);

}  // namespace plumbline::firmware
