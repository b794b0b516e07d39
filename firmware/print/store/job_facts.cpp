#include "firmware/print/store/job_facts.hpp"

#include <algorithm>
#include <bit>

#include "firmware/io/hash64.hpp"
#include "slicer/core/words/printable_text.hpp"

namespace plumbline {

namespace {

template <std::size_t Size>
std::array<char, Size> filled(std::string_view text) {
  std::array<char, Size> name = {};
  std::copy_n(text.begin(), std::min(text.size(), name.size()), name.begin());
  return name;
}

}  // namespace

ShortName short_name(std::string_view text) { return filled<std::tuple_size_v<ShortName>>(text); }
FileName file_name(std::string_view text) { return filled<std::tuple_size_v<FileName>>(text); }
std::string_view view(std::span<const char> name) {
  return {name.data(), static_cast<std::size_t>(std::find(name.begin(), name.end(), '\0') - name.begin())};
}

void JobFacts::add_file(std::string_view name) { files[file_count++] = file_name(PrintableText(name, 79).view()); }

std::uint64_t hash_of(const BoardFile& board) {
  Hash64 hash;
  const auto number = [&hash](double value) { hash.add_value(std::bit_cast<std::uint64_t>(value)); };
  hash.add_text(board.name);
  number(board.columns);
  number(board.rows);
  number(board.pixel_pitch_x_mm);
  number(board.pixel_pitch_y_mm);
  number(board.travel_mm);
  if (board.machine) {
    const MachineFile& m = *board.machine;
    for (const double value : {static_cast<double>(m.panel.rgb), static_cast<double>(m.panel.mirror),
                               static_cast<double>(m.panel.rotation_deg), m.rotation_distance_mm,
                               static_cast<double>(m.full_steps_per_rotation), static_cast<double>(m.microsteps),
                               m.end_stop_height_mm, m.power_mw_cm2}) {
      number(value);
    }
  }
  return hash.value();
}

}  // namespace plumbline
