#pragma once

#include "firmware/io/descriptor.hpp"
#include "firmware/print/job/journal.hpp"

namespace plumbline::firmware {

/// A journal's storage, or another record's, in a file: pread, pwrite, fdatasync. Short and interrupted calls are continued.
class JournalFile final : public JournalStorage {
 public:
  JournalFile() = default;
  /// @param file  open for reading and writing
  /// @param size  of the file, bytes
  /// @param what  for messages
  JournalFile(Descriptor file, std::size_t size, const char* what = "the journal")
      : file_(std::move(file)), size_(size), what_(what) {}

  std::size_t size() const override { return size_; }
  Status read(std::size_t offset, std::span<std::byte> bytes) override;
  Status write(std::size_t offset, std::span<const std::byte> bytes) override;
  Status sync() override;

 private:
  Descriptor file_;
  std::size_t size_ = 0;
  const char* what_ = "the journal";
};

}  // namespace plumbline::firmware
