#include "firmware/settings/print_values.hpp"

#include "firmware/io/text/fixed_text.hpp"
#include "firmware/messages/printer_code.hpp"
#include "slicer/core/numbers/to_number.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline::firmware::inline settings {

Expected<std::optional<double>> parse_print_value(const PrintField& field, std::string_view text) {
  if (text.empty()) return std::optional<double>();
  const auto number = to_number<double>(text);
  if (number && field.allows(*number)) return number;
  return telling(Told(PrinterCode::kSettingValue, {}, field.name),
                 fail(ErrorCode::kBadSetting, "%.*s: found '%s', allowed is %s%g to %g%s",
                      static_cast<int>(field.name.size()), field.name.data(), PrintableText(text, 40).c_str(),
                      field.is_whole() ? "a whole number from " : "", field.low, field.high, field.unit));
}

Status parse_assignment(std::string_view text, PrintValues& values) {
  const auto equals = text.find('=');
  const PrintField* const field = find_print_field(text.substr(0, equals));
  if (equals == std::string_view::npos || field == nullptr || !field->can_be_changed()) {
    FixedText<500> known;
    for (const PrintField& one : kPrintFields) {
      if (!one.can_be_changed()) continue;
      known.add("%s%.*s", known.view().empty() ? "" : ", ", static_cast<int>(one.name.size()), one.name.data());
    }
    return fail(ErrorCode::kBadSetting, "'%s' is not KEY=VALUE.\tKEY is one of %s", PrintableText(text, 60).c_str(),
                known.c_str());
  }
  const auto value = parse_print_value(*field, text.substr(equals + 1));
  PLUMBLINE_TRY(value);
  values[index_of(field->key)] = *value;
  return {};
}

}  // namespace plumbline::firmware::inline settings
