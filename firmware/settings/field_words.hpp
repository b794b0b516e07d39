#pragma once
/// What people are shown of print settings.

#include <string_view>

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/settings/print_fields.hpp"
#include "firmware/told/language.hpp"

namespace plumbline {

class JsonWriter;

/// "exposure time"; "Belichtung"
FixedText<32> field_words(PrintKey key, Language language);
/// "profile"; "Profil"
std::string_view source_words(ValueSource source, Language language);

/// Writes both for browsers: "fields" by the field's name, and "sources" by the word in state lines.
void write_field_words(JsonWriter& json, Language language);

}  // namespace plumbline
