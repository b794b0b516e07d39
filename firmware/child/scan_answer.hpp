#pragma once
/// What the slicing child hands back. None of it can be trusted: a scan may have made the child do anything.

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/child/job_answer.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "firmware/settings/print_fields.hpp"
#include "firmware/slice/orientation_proposals.hpp"
#include "slicer/checks/stack_findings.hpp"
#include "slicer/core/error.hpp"
#include "slicer/core/resin/layer_steps.hpp"
#include "slicer/rrep/point_proof.hpp"

namespace plumbline::firmware {

/// Numbers and characters only, so that no value of a byte is invalid. check_answer() says what of it holds.
struct ScanAnswer {
  static constexpr std::uint32_t kSliced = 0x50534C31;   ///< "PSL1"
  static constexpr std::uint32_t kRefused = 0x50535231;  ///< "PSR1"
  static constexpr std::uint32_t kJob = 0x50534A31;      ///< "PSJ1"
  static constexpr std::uint32_t kArchive = 0x50534131;  ///< "PSA1"
  static constexpr std::uint32_t kLayer =
      0x50534D31;  ///< "PSM1": the mask lies where it was asked for, its greys behind it
  static constexpr std::uint32_t kProposals = 0x50534F31;  ///< "PSO1"
  static constexpr std::uint32_t kGlance = 0x50534731;     ///< "PSG1": there is a picture of the scan
  static constexpr std::size_t kMostRemarks = 8;

  std::uint32_t kind = 0;

  // kRefused: an Error.
  std::uint32_t code = 0;
  std::uint32_t advice_at = 0;  ///< where the message's advice begins; 0: it has none
  std::array<char, Error::kCapacity> message{};
  Told told;  ///< what the message says

  // kSliced: a SlicedScan. Places are bytes from the arena's beginning.
  std::uint64_t bottom_used = 0;  ///< bytes; all that follows is below
  std::uint32_t layers = 0;
  std::uint32_t is_exact = 0;     ///< RRep::is_exact; any other number than 0 is true
  LayerSteps steps;               ///< of the print's layers
  std::uint32_t supports = 0;     ///< how many
  std::uint64_t crossings = 0;    ///< how many
  std::uint64_t first_at = 0;     ///< RRep::first
  std::uint64_t packed_at = 0;    ///< RRep::packed
  std::uint64_t supports_at = 0;  ///< Supports::list
  struct Ray {
    std::uint64_t crossings = 0, first_at = 0, packed_at = 0;
  };
  std::array<Ray, kRaysAround> other_rays{};  ///< RRep::others, if SliceSettings::grey is full
  std::uint64_t scan_hash = 0;
  StackFindings findings;
  PointProof proof;
  std::uint32_t remarks = 0;
  std::array<std::array<char, kLongestSentence>, kMostRemarks> remark{};  ///< for_each_remark()
  std::array<Told, kMostRemarks> remark_told{};                           ///< what each of them says

  JobAnswer job;  ///< kJob

  Proposals proposals{};  ///< kProposals

  // kArchive: a SlicedArchive. Of the above it has layers, bottom_used and findings.
  std::uint64_t archive_at = 0;           ///< SlicedArchive::layers
  std::array<std::uint32_t, 3> turn{};    ///< MaskTurn, in its order
  std::uint32_t turned = 0;               ///< any other number than 0 is true
  std::array<std::uint32_t, 4> extent{};  ///< MaskExtent, in its order
  std::array<std::uint64_t, 3> grey{};    ///< GreyShare, in its order
  double layer_height_mm = 0;             ///< of the grid
  PassedValues values;                    ///< what the archive says

  std::uint64_t greys = 0;  ///< kLayer: runs of grey pixels
};

}  // namespace plumbline::firmware
