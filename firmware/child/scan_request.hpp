#pragma once
/// What the firmware asks the slicing child for.

#include <cstdint>
#include <optional>

#include "firmware/io/fixed_text.hpp"
#include "slicer/slice_settings.hpp"
#include "slicer/supports/support_settings.hpp"

namespace plumbline {

/// One scan, or a stick's job file. Its bytes come through the child's descriptor.
struct ScanRequest {
  bool is_job_file = false;  ///< only its name and size count
  FixedText<256> name;
  std::optional<std::uint64_t> size;  ///< bytes, if known
  SliceSettings settings;             ///< with a printer
  std::optional<SupportSettings> supports;
};

}  // namespace plumbline
