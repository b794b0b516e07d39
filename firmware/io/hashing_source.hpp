#pragma once
/// Scans that are hashed while they are read.

#include <array>
#include <optional>
#include <span>

#include "firmware/io/hash64.hpp"
#include "slicer/core/byte_source.hpp"
#include "slicer/reader/scan_sources.hpp"

namespace plumbline::firmware {

/// Passes a stream on and hashes its bytes, each once: those that are read again after a rewind() don't count.
class HashingSource final : public ByteSource {
 public:
  /// @param source  must outlive this
  explicit HashingSource(ByteSource& source) : source_(source) {}
  Expected<std::size_t> read(std::span<std::byte> buffer) override;
  std::string_view name() const override { return source_.name(); }
  std::optional<std::uint64_t> size() const override { return source_.size(); }
  Status rewind() override;
  std::uint64_t hash() const { return hash_.value(); }  ///< of the bytes read so far

 private:
  ByteSource& source_;
  Hash64 hash_;
  std::uint64_t at_ = 0;      ///< byte of the stream
  std::uint64_t hashed_ = 0;  ///< bytes of the stream
};

/// Hashes all files of a scan.
class HashingSources {
 public:
  /// @param scan  1 to kMostScans files; they must outlive this
  explicit HashingSources(ScanSources scan);
  HashingSources(const HashingSources&) = delete;
  HashingSources& operator=(const HashingSources&) = delete;

  ScanSources sources() const { return ScanSources(pointers_).first(count_); }
  /// One file: the hash of its bytes. Several: the hash of their hashes, in order.
  std::uint64_t hash() const;

 private:
  std::size_t count_;
  std::array<std::optional<HashingSource>, kMostScans> hashing_;
  std::array<ByteSource*, kMostScans> pointers_ = {};
};

}  // namespace plumbline::firmware
