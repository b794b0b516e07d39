#include "firmware/settings/field_words.hpp"

#include "firmware/io/text/json_writer.hpp"

namespace plumbline {
namespace {

/// By PrintKey.
constexpr std::array<std::string_view, kPrintKeyCount> kGermanFields = {
    "Schichthöhe",  "erste Schicht",      "untere Schichten",    "deren Belichtung",  "Übergangsschichten",
    "Belichtung",   "Ruhe vor dem Licht", "Ruhe nach dem Licht", "Abziehen",          "Tempo dabei",
    "Heben danach", "Tempo dabei",        "Warten oben",         "Tempo beim Senken", "letztes Stück langsam",
    "Tempo dabei",  "Elefantenfuß",       "Heben bei Pause",
};
/// By ValueSource.
constexpr std::array<std::string_view, kSourceWords.size()> kGermanSources = {"Profil", "Archiv", "Drucker",
                                                                              "von Hand"};
constexpr std::array<std::string_view, kSourceWords.size()> kEnglishSources = {"profile", "archive", "printer",
                                                                               "by hand"};

}  // namespace

FixedText<32> field_words(PrintKey key, Language language) {
  const bool english = language == Language::kEnglish;
  const std::string_view words = english ? kPrintFields[index_of(key)].name : kGermanFields[index_of(key)];
  FixedText<32> text;
  for (const char c : words) text.add("%c", english && c == '_' ? ' ' : c);
  return text;
}

std::string_view source_words(ValueSource source, Language language) {
  return (language == Language::kEnglish ? kEnglishSources : kGermanSources)[static_cast<std::size_t>(source)];
}

void write_field_words(JsonWriter& json, Language language) {
  json.key("fields");
  json.begin_object(JsonWriter::Layout::kOneLine);
  for (const PrintField& field : kPrintFields) json.member(field.name, field_words(field.key, language).view());
  json.end_object();
  json.key("sources");
  json.begin_object(JsonWriter::Layout::kOneLine);
  for (std::size_t i = 0; i < kSourceWords.size(); ++i) {
    json.member(kSourceWords[i], source_words(static_cast<ValueSource>(i), language));
  }
  json.end_object();
}

}  // namespace plumbline
