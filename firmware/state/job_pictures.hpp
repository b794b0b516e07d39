#pragma once
/// Pictures of the job at hand, small enough to be kept for as long as it lasts. Fixed in size.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plumbline {

/// @tparam Channels  1: grey levels; 3: red, green and blue. A byte each, row after row from the top
template <std::size_t Channels, std::size_t MostColumns, std::size_t MostRows>
struct FixedPicture {
  static constexpr std::size_t kMostColumns = MostColumns, kMostRows = MostRows, kChannels = Channels;

  std::array<std::uint8_t, Channels * MostColumns * MostRows> memory{};
  std::uint32_t columns = 0, rows = 0;  ///< 0: there is no picture
  std::uint32_t number = 0;             ///< rises with each new picture

  bool there() const { return columns > 0; }
  std::span<const std::uint8_t> bytes() const { return {memory.data(), Channels * columns * rows}; }
  std::span<std::uint8_t> bytes() { return {memory.data(), Channels * columns * rows}; }
};

struct JobPictures {
  FixedPicture<3, 320, 180> preview;  ///< what has been sliced, from three sides
  FixedPicture<1, 320, 320> layer;    ///< the mask of the layer that is printed
};

}  // namespace plumbline
