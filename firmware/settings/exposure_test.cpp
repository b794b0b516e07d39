#include "firmware/settings/exposure_test.hpp"

#include <algorithm>

#include "firmware/settings/print_fields.hpp"
#include "firmware/settings/print_values.hpp"

namespace plumbline::firmware::inline settings {

Expected<ExposureTest> parse_exposure_test(std::string_view text) {
  const auto found = static_cast<std::size_t>(std::ranges::count(text, ',')) + 1;
  if (found < 2 || found > ExposureTest::kMostStrips) {
    return fail(ErrorCode::kBadSetting, "found %zu exposure%s, allowed are 2 to %u, such as 1.6s,2s,2.4s", found,
                found == 1 ? "" : "s", ExposureTest::kMostStrips);
  }
  ExposureTest test;
  while (test.strips < found) {
    std::string_view word = text.substr(0, text.find(','));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (word.ends_with('s')) word.remove_suffix(1);
    const auto seconds = parse_print_value(kPrintFields[index_of(PrintKey::kExposureTime)], word);
    PLUMBLINE_TRY(seconds);
    if (!*seconds) return fail(ErrorCode::kBadSetting, "exposure %u is empty", test.strips + 1);
    if (test.strips > 0 && **seconds <= test.longest()) {
      return fail(ErrorCode::kBadSetting, "found %g s after %g s, allowed is a longer exposure for each strip",
                  **seconds, test.longest());
    }
    test.seconds[test.strips++] = **seconds;
  }
  return test;
}

}  // namespace plumbline::firmware::inline settings
