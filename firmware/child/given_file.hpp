#pragma once

#include "firmware/child/scan_request.hpp"
#include "slicer/core/byte_source.hpp"

namespace plumbline {

/// The file that a child reads: its only descriptor, 0.
class GivenFile final : public ByteSource {
 public:
  explicit GivenFile(const ScanRequest& request) : request_(request) {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return request_.name.view(); }
  std::optional<std::uint64_t> size() const override { return request_.size; }
  Status rewind() override;

 private:
  const ScanRequest& request_;
};

}  // namespace plumbline
