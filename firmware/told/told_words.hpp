#pragma once
/// German texts of the printer's messages. English needs no table: the sentence that goes beside a code is English.

#include <optional>
#include <string_view>

#include "firmware/told/language.hpp"
#include "firmware/told/printer_code.hpp"

namespace plumbline {

class JsonWriter;

/// What happened, and what somebody with buttons and a stick does about it.
struct ToldWords {
  std::string_view sentence;  ///< without a full stop
  std::string_view remedy;    ///< a sentence or two; may be empty
};

/// The table's texts. They have places: {area_mm2} is a fact and {name} Told::text; {count?Insel|Inseln} chooses by whether the fact is 1; what
/// stands in [ ] is left out if one of its places is not told.
/// @returns none: there is none in this language. English has no table: the sentence that goes beside a code is English
std::optional<ToldWords> told_words(ToldCode code, Language language);

/// Writes the table for browsers: "told", by code the sentence and the remedy, and "digits", by fact as FactFormat::decimals has them.
void write_told_words(JsonWriter& json, Language language);

}  // namespace plumbline
