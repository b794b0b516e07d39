#pragma once
/// Whether the plate is empty, as far as anybody has said. Kept in the state folder, so that it outlives a restart:
///
///   STATE/plate-is-empty   somebody has confirmed it, and no print has begun since
///
/// Without that file the plate counts as in use: on a new printer, after a print, and if the storage has lost it.

#include <string>

#include "firmware/io/descriptor.hpp"
#include "firmware/io/text/fixed_text.hpp"
#include "slicer/core/error.hpp"

namespace plumbline {

class PlateRecord {
 public:
  /// @param folder  that of the JobStore, which has created and locked it
  /// @retval ErrorCode::kCannotOpen  the path, the reason
  [[nodiscard]] static Expected<PlateRecord> open(const std::string& folder);

  bool is_empty() const { return empty_; }

  /// A print begins. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite  the print must not begin
  [[nodiscard]] Status take();

  /// Somebody says that the plate is empty. Durable when it returns.
  /// @retval ErrorCode::kCannotWrite  the plate still counts as in use
  [[nodiscard]] Status confirm_empty();

 private:
  PlateRecord() = default;
  [[nodiscard]] tl::unexpected<Error> cannot_write() const;

  FixedPath path_;
  Descriptor folder_;
  bool empty_ = false;
};

}  // namespace plumbline
