#include "firmware/messages/catalogue.hpp"

#include <algorithm>
#include <cassert>

namespace plumbline::firmware {
namespace {

struct KeyedText {
  std::string_view key, text;
};

#include "firmware/messages/message_tables.inc"

static_assert(kCodeKeys.size() == kAllCodes);

std::size_t index_of(Language language) { return static_cast<std::size_t>(language); }

std::string_view find(std::span<const KeyedText> texts, std::string_view key) {
  const auto found = std::find_if(texts.begin(), texts.end(), [&](const KeyedText& row) { return row.key == key; });
  assert(found != texts.end());
  return found->text;
}

}  // namespace

std::string_view to_string(ToldCode code) { return kCodeKeys[static_cast<std::size_t>(code)]; }

std::string_view words(Words which, Language language) {
  return kScreen[index_of(language)][static_cast<std::size_t>(which)];
}

std::optional<ToldWords> told_words(ToldCode code, Language language) {
  const ToldWords& said = kTold[index_of(language)][static_cast<std::size_t>(code)];
  return said.sentence.empty() ? std::nullopt : std::optional(said);
}

const ToldWords& english_remedies(ToldCode code) {
  return kTold[index_of(Language::kEnglish)][static_cast<std::size_t>(code)];
}

std::span<const FaultWords> fault_words(Language language) { return kFaults[index_of(language)]; }

std::string_view field_words(std::string_view name, Language language) {
  return find(kFields[index_of(language)], name);
}

std::string_view source_words(std::string_view word, Language language) {
  return find(kSources[index_of(language)], word);
}

std::string_view remedy_words(std::string_view key, Language language) {
  return find(kRemedies[index_of(language)], key);
}

char decimal_point(Language language) { return kDecimals[index_of(language)]; }

}  // namespace plumbline::firmware
