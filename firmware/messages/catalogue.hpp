#pragma once
/// The texts of en.toml, de.toml and any other language, as tables.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/messages/message_tables.hpp"
#include "firmware/messages/printer_code.hpp"

namespace plumbline::firmware {

/// What happened, and what somebody does about it.
struct ToldWords {
  std::string_view sentence;  ///< without a full stop
  std::string_view remedy;    ///< with buttons and a stick: a sentence or two; may be empty
  std::string_view terminal;  ///< the same at a terminal; may be empty
};

/// A fault's title, what it means and what to do next.
struct FaultWords {
  std::uint16_t number;  ///< FaultCode
  std::string_view title;
  std::string_view meaning;  ///< a sentence
  std::string_view next;     ///< another
};

/// Some have places for numbers, as printf has them: kStep and kLayerOf two %u, kLayers, kScansAsOne, kFolderHolds and kProposal one, kTimeLeft, kPageCode, kResinLeft, kLampHas, kResinHas and kBoardHas
/// a %s.
std::string_view words(Words which, Language language);

/// The texts have places: {area_mm2} is a fact and {name} Told::text; {count?Insel|Inseln} chooses by whether the fact is 1; what stands in [ ]
/// is left out if one of its places is not told.
/// @returns none: there is no code, or the language is English, whose sentence goes beside the code
std::optional<ToldWords> told_words(ToldCode code, Language language);
/// What to do about it, in English: where that depends on who reads it, its sentence does not say so. All texts are empty for most codes.
const ToldWords& english_remedies(ToldCode code);

/// By number.
std::span<const FaultWords> fault_words(Language language);

/// A print setting: "exposure time" for "exposure_time".
/// @param name  PrintField::name
std::string_view field_words(std::string_view name, Language language);
/// Where a setting's value comes from: "by hand" for "person".
/// @param word  one of kSourceWords
std::string_view source_words(std::string_view word, Language language);

/// What a setting that mends a finding does: "Add supports" for "supports". Its value follows "It is in" and "Make the height".
/// @param key  Remedy::key
std::string_view remedy_words(std::string_view key, Language language);

/// '.' or ','
char decimal_point(Language language);

}  // namespace plumbline::firmware
