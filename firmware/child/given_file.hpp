#pragma once

#include "firmware/child/scan_request.hpp"
#include "slicer/core/byte_source.hpp"

namespace plumbline::firmware {

/// A file that a child reads.
class GivenFile final : public ByteSource {
 public:
  GivenFile(int descriptor, const RequestedFile& file) : descriptor_(descriptor), file_(file) {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return file_.name.view(); }
  std::optional<std::uint64_t> size() const override { return file_.size; }
  Status rewind() override;

 private:
  int descriptor_;
  const RequestedFile& file_;
};

}  // namespace plumbline::firmware
