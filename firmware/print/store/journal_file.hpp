#pragma once

#include "firmware/io/descriptor.hpp"
#include "firmware/print/store/journal.hpp"

namespace plumbline {

/// A journal's storage in a file: pread, pwrite, fdatasync. Short and interrupted calls are continued.
class JournalFile final : public JournalStorage {
 public:
  JournalFile() = default;
  /// @param file  open for reading and writing
  /// @param size  of the file, bytes
  JournalFile(Descriptor file, std::size_t size) : file_(std::move(file)), size_(size) {}

  std::size_t size() const override { return size_; }
  Status read(std::size_t offset, std::span<std::byte> bytes) override;
  Status write(std::size_t offset, std::span<const std::byte> bytes) override;
  Status sync() override;

 private:
  Descriptor file_;
  std::size_t size_ = 0;
};

}  // namespace plumbline
