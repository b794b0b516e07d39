#pragma once
/// Pictures of the job at hand, small enough to be kept for as long as it lasts. Fixed in size, never on the heap.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/pictures/part_model.hpp"
#include "slicer/core/arena.hpp"
#include "slicer/core/bit_image.hpp"
#include "slicer/core/error.hpp"
#include "slicer/orientation/orientations.hpp"
#include "slicer/rrep/rrep.hpp"
#include "slicer/supports/drawing/supports.hpp"

namespace plumbline::firmware::inline pictures {

/// @tparam Channels  1: grey levels; 3: red, green and blue. A byte each, row after row from the top
template <std::size_t Channels, std::uint32_t MostColumns, std::uint32_t MostRows>
struct FixedPicture {
  static constexpr std::size_t kChannels = Channels;
  static constexpr std::uint32_t kMostColumns = MostColumns, kMostRows = MostRows;

  std::uint32_t columns = 0, rows = 0;  ///< 0: there is no picture
  std::array<std::uint8_t, Channels * MostColumns * MostRows> memory{};

  bool there() const { return columns > 0 && rows > 0; }
  std::span<const std::uint8_t> bytes() const { return {memory.data(), Channels * columns * rows}; }
  std::span<std::uint8_t> bytes() { return {memory.data(), Channels * columns * rows}; }
  void clear() { columns = rows = 0; }
};

using PreviewPicture = FixedPicture<3, 320, 180>;
using IssuesPicture = FixedPicture<3, 320, 180>;
using LayerPicture = FixedPicture<1, 320, 320>;
using ProposalPicture = FixedPicture<3, 160, 160>;
/// Of the scan as it lies, then of the best ways up.
using ProposalPictures = std::array<ProposalPicture, 1 + kBestOrientations>;

/// A scan, small, before anything is known of it but its points.
using ScanPicture = FixedPicture<3, 64, 64>;

/// What is drawn of a job when it has been sliced.
struct SlicedPictures {
  PreviewPicture preview;  ///< what has been sliced, from three sides
  IssuesPicture issues;    ///< where the checks have found something
  PartModel part;          ///< what has been sliced, in 3D

  void clear() {
    preview.clear();
    issues.clear();
    part.clear();
  }
};

struct JobPictures : SlicedPictures {
  ProposalPictures proposals;          ///< all of them are there, or none
  std::array<LayerPicture, 2> layers;  ///< the mask of the layer that is printed, and the one that is made next
  std::size_t shown = 0;               ///< of layers
  std::uint32_t preview_number = 0, issues_number = 0, part_number = 0, layer_number = 0,
                proposal_number = 0;  ///< rise with each new picture

  const LayerPicture& layer() const { return layers[shown]; }
  LayerPicture& next_layer() { return layers[1 - shown]; }
  void show_next_layer() {
    shown = 1 - shown;
    ++layer_number;
  }
  void clear_proposals() {
    for (ProposalPicture& proposal : proposals) proposal.clear();
  }
  void clear() {
    SlicedPictures::clear();
    clear_proposals();
    for (LayerPicture& layer : layers) layer.clear();
  }
};

/// Leaves 5 bits of each level, as many as a small screen shows: the picture's PNG has to fit a line of the state socket.
void keep_five_bits(std::span<std::uint8_t> levels);

/// Bytes that draw_preview_picture() takes.
std::size_t preview_picture_bytes(const PrintGrid& grid);

/// Draws the print from three sides, without texts.
/// @param arena  preview_picture_bytes() are taken from its top and released
/// @retval ErrorCode::kOutOfMemory  the arena has no room; there is no picture then
[[nodiscard]] Status draw_preview_picture(const RRep& rrep, const Supports& supports, Arena& arena,
                                          PreviewPicture& picture);

/// Draws a picture of the print in any size: from three sides if it is wider than tall, else from the front.
/// @param arena  the picture and room to draw it are taken from its top; only the latter is released
/// @returns the pixels, RGB, row after row from the top; black if no mask has a pixel
/// @retval ErrorCode::kOutOfMemory
[[nodiscard]] Expected<std::span<std::uint8_t>> draw_thumbnail(const RRep& rrep, const Supports& supports,
                                                               std::uint32_t columns, std::uint32_t rows, Arena& arena);

/// Reduces a mask: each pixel is the mean of a square of the mask's. Shows what the print takes and a twelfth around it, or all of the mask if that
/// is not known. On a core of x86-64 it takes 1.5 ms for
/// 1440 x 2560 pixels and 6 ms for 7680 x 4320.
void draw_layer_picture(ConstBitImage mask, const PartBox& part, LayerPicture& picture);

}  // namespace plumbline::firmware::inline pictures
