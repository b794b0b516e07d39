#pragma once
/// Converts a mask to the pixels that go over the panel's cable.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/panel_layout.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/grey_runs.hpp"

namespace plumbline::inline hal::inline linux_board {

/// Writes a mask as XRGB8888, little endian: a pixel that lets light through is 255 in its colour, or in all three without packing.
/// Writes each byte of the rows once, in order, and reads none, because display memory is slow to read.
/// @param layout  must pass check()
/// @param mask    layout.columns x layout.rows pixels
/// @param pixels  layout.mode_height() rows of `pitch` words
/// @param pitch   words a row, layout.mode_width() or more; the rest of a row becomes black
void pack_pixels(const PanelLayout& layout, ConstBitImage mask, std::span<std::uint32_t> pixels, std::size_t pitch);

/// Writes grey pixels over those of pack_pixels(). Reads none, as above.
/// @param runs    ascending, of the mask
/// @param values  GreyScale::values()
void pack_greys(const PanelLayout& layout, std::span<const GreyRun> runs, const GreyScale::Values& values,
                std::span<std::uint32_t> pixels, std::size_t pitch);

/// Writes all pixels that get light over those of pack_pixels(), dimmed where the lamp is brighter than at its darkest place. Instead of
/// pack_greys().
/// @param shares  known()
void pack_evenly(const PanelLayout& layout, ConstBitImage mask, std::span<const GreyRun> runs, const LampShares& shares,
                 const GreyScale::Values& values, std::span<std::uint32_t> pixels, std::size_t pitch);

}  // namespace plumbline::inline hal::inline linux_board
