#pragma once
/// What the printer tells, in the languages of the screen and the page.

#include <optional>
#include <string_view>

#include "firmware/io/fixed_text.hpp"
#include "firmware/settings/language.hpp"
#include "slicer/core/told.hpp"

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

using ToldText = FixedText<400>;
/// A text of the table with its values, in the way of the language.
ToldText filled_in(std::string_view pattern, const Told& told, Language language);

/// "3 Inseln bis 113 mm² bei x 34,2, y 61,0 mm, Schicht 702 (35,10 mm). Stützen setzen oder das Objekt drehen."
/// @param english  what it is called if there is nothing in the table
ToldText worded(const Told& told, Language language, std::string_view english);

/// Writes the table for browsers: "told", by code the sentence and the remedy, and "digits", by fact as FactFormat::decimals has them.
void write_told_words(JsonWriter& json, Language language);

}  // namespace plumbline
