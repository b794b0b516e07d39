#include "firmware/messages/told_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "firmware/messages/catalogue.hpp"

namespace plumbline::firmware {
namespace {

FixedText<40> number_text(const FactFormat& format, double value, Language language) {
  FixedText<40> text;
  const int digits = -format.decimals;
  const bool rounded = digits > 0 && std::abs(value) >= std::pow(10, digits - 1);
  std::array<char, 40> raw{};
  std::snprintf(raw.data(), raw.size(), digits > 0 && !rounded ? "%.*g" : "%.*f",
                rounded ? 0 : std::abs(format.decimals), value);
  std::replace(raw.begin(), raw.end(), '.', decimal_point(language));
  text.add("%s", raw.data());
  return text;
}

/// Fills in texts with places, one after the other.
class Filling {
 public:
  Filling(const Told& told, Language language) : told_(told), language_(language) {}

  void add(std::string_view pattern) {
    while (!pattern.empty()) {
      const auto mark = std::min(pattern.find_first_of("{["), pattern.size());
      put(pattern.substr(0, mark));
      pattern.remove_prefix(mark);
      if (pattern.empty()) break;
      const bool place = pattern.front() == '{';
      const auto end = pattern.find(place ? '}' : ']');
      const auto inside = pattern.substr(1, end - 1);
      if (place) {
        add_place(inside);
      } else if (is_told(inside)) {
        add(inside);
      }
      pattern.remove_prefix(end + 1);
    }
  }
  const ToldText& text() const { return text_; }

 private:
  void put(std::string_view text) { text_.add("%.*s", static_cast<int>(text.size()), text.data()); }

  /// "area_mm2", "name", or "count?Insel|Inseln"
  void add_place(std::string_view place) {
    if (place == "name") return put(told_.name());
    const auto question = place.find('?');
    const auto number = number_of(place.substr(0, question));
    if (!number) return;
    if (question == std::string_view::npos)
      return put(number_text(format_of(number->fact), number->value, language_).view());
    const auto one = place.substr(question + 1), many = one.substr(one.find('|') + 1);
    put(number->value == 1 ? one.substr(0, one.find('|')) : many);
  }
  std::optional<Told::Number> number_of(std::string_view name) const {
    for (std::size_t i = 0; i < told_.count; ++i) {
      if (format_of(told_.facts[i]).name == name) return Told::Number{told_.facts[i], told_.values[i]};
    }
    return std::nullopt;
  }
  /// Whether all places of a text are told.
  bool is_told(std::string_view text) const {
    for (auto at = text.find('{'); at != std::string_view::npos; at = text.find('{', at + 1)) {
      const auto place = text.substr(at + 1, text.find_first_of("?}", at) - at - 1);
      if (place == "name" ? told_.name().empty() : !number_of(place)) return false;
    }
    return true;
  }

  const Told& told_;
  Language language_;
  ToldText text_;
};

Advised advised(std::string_view sentence, std::string_view remedy, const Told& told) {
  Advised text;
  text.add("%.*s", static_cast<int>(sentence.size()), sentence.data());
  if (!remedy.empty()) text.add(". %s", filled_in(remedy, told, Language::kEnglish).c_str());
  return text;
}

}  // namespace

ToldText filled_in(std::string_view pattern, const Told& told, Language language) {
  Filling filling(told, language);
  filling.add(pattern);
  return filling.text();
}

ToldText worded(const Told& told, Language language, std::string_view english) {
  ToldText text;
  const auto words = told_words(told.code, language);
  if (!words) {
    text.add("%.*s", static_cast<int>(english.size()), english.data());
    return text;
  }
  Filling filling(told, language);
  filling.add(words->sentence);
  if (words->remedy.empty()) return filling.text();
  filling.add(". ");
  filling.add(words->remedy);
  return filling.text();
}

Advised at_terminal(const Told& told, std::string_view sentence) {
  return advised(sentence, english_remedies(told.code).terminal, told);
}

Advised at_printer(const Told& told, std::string_view sentence) {
  return advised(sentence, english_remedies(told.code).remedy, told);
}

ToldText printer_remedy(const Told& told, std::string_view advice) {
  const std::string_view known = english_remedies(told.code).remedy;
  if (!known.empty()) return filled_in(known, told, Language::kEnglish);
  ToldText text;
  text.add("%.*s", static_cast<int>(advice.size()), advice.data());
  return text;
}

Advised at_terminal(const Error& error) {
  const bool known = !english_remedies(error.told().code).terminal.empty();
  return at_terminal(error.told(), known ? error.finding() : error.message());
}

}  // namespace plumbline::firmware
