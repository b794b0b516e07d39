#include "firmware/archive/layer_numbers.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware::inline archive {
namespace {

bool holds(std::string_view name, std::string_view word) {
  for (std::size_t at = 0; at + word.size() <= name.size(); ++at) {
    if (same_word(name.substr(at, word.size()), word)) return true;
  }
  return false;
}

/// macOS adds a second, hidden file for each.
bool is_picture(std::string_view name) { return has_ending(name, ".png") && !file_of_entry(name).starts_with('.'); }

std::optional<std::uint64_t> last_number(std::string_view name) {
  constexpr std::string_view kDigits = "0123456789";
  const auto last = name.find_last_of(kDigits);
  if (last == std::string_view::npos) return std::nullopt;
  const auto before = name.find_last_not_of(kDigits, last);
  const auto first = before == std::string_view::npos ? 0 : before + 1;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + first, name.data() + last + 1, number);
  return error == std::errc() ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string_view file_of_entry(std::string_view name) {
  const auto slash = name.find_last_of("/\\");
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

bool is_thumbnail(std::string_view name) {
  // 3d.png: NanoDLP's
  return is_picture(name) &&
         (holds(name, "thumbnail") || holds(name, "preview") || same_word(file_of_entry(name), "3d.png"));
}

std::optional<std::uint64_t> number_of_layer(std::string_view name) {
  if (!is_picture(name) || is_thumbnail(name)) return std::nullopt;
  const auto file = file_of_entry(name);
  return last_number(file.substr(0, file.size() - 4));
}

Status check_none_missing(std::size_t layers, FunctionRef<std::uint64_t(std::size_t)> number_of, const char* where) {
  // Some programs number the layers in steps. Where a step is longer than another, a layer is missing.
  std::uint64_t step = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t i = 1; i < layers; ++i) step = std::min(step, number_of(i) - number_of(i - 1));
  for (std::size_t i = 1; i < layers; ++i) {
    const std::uint64_t before = number_of(i - 1);
    const std::uint64_t after = number_of(i);
    if (after - before == step) continue;
    return fail(ErrorCode::kMalformed, "%s: layer %llu is missing between %llu and %llu.\tCopy or export it again",
                where, static_cast<unsigned long long>(before + step), static_cast<unsigned long long>(before),
                static_cast<unsigned long long>(after));
  }
  return {};
}

}  // namespace plumbline::firmware::inline archive
