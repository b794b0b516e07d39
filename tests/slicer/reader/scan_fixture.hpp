#pragma once
/// Scans in memory, and the results of reading them.

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "slicer/reader/scan_reader.hpp"

namespace plumbline::testing {

/// Delivers bytes in pieces of the given lengths, cyclically; with an empty list, as many as requested.
class MemorySource final : public ByteSource {
 public:
  MemorySource(std::string_view bytes, std::string_view name, std::vector<std::size_t> pieces = {})
      : bytes_(bytes), name_(name), pieces_(std::move(pieces)) {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    if (fails_at_ && position_ >= *fails_at_) return fail(ErrorCode::kCannotRead, "the stick was pulled");
    std::size_t count = std::min(buffer.size(), bytes_.size() - position_);
    if (!pieces_.empty()) count = std::min(count, pieces_[turn_++ % pieces_.size()]);
    if (count > 0) std::memcpy(buffer.data(), bytes_.data() + position_, count);
    position_ += count;
    return count;
  }
  std::string_view name() const override { return name_; }
  std::optional<std::uint64_t> size() const override {
    return knows_size_ ? std::optional<std::uint64_t>(bytes_.size()) : std::nullopt;
  }
  Status rewind() override {
    if (!rewinds_) return ByteSource::rewind();
    position_ = 0;
    ++rewound;
    return {};
  }
  void be_a_pipe() { rewinds_ = false; }
  void fail_at(std::size_t position) { fails_at_ = position; }
  void forget_size() { knows_size_ = false; }

  int rewound = 0;

 private:
  std::string_view bytes_;
  std::string_view name_;
  std::vector<std::size_t> pieces_;
  std::size_t position_ = 0;
  std::size_t turn_ = 0;
  std::optional<std::size_t> fails_at_;
  bool knows_size_ = true;
  bool rewinds_ = true;
};

/// Delivers `head`, then `piece` many times, then `tail`: files larger than a test's memory.
class RepeatingSource final : public ByteSource {
 public:
  RepeatingSource(std::string head, std::string piece, std::uint64_t times, std::string tail, std::string name)
      : head_(std::move(head)),
        piece_(std::move(piece)),
        tail_(std::move(tail)),
        name_(std::move(name)),
        middle_(piece_.size() * times) {}

  Expected<std::size_t> read(std::span<std::byte> buffer) override {
    std::size_t count = 0;
    for (; count < buffer.size() && position_ < head_.size() + middle_ + tail_.size(); ++count, ++position_) {
      buffer[count] = static_cast<std::byte>(at(position_));
    }
    return count;
  }
  std::string_view name() const override { return name_; }
  std::optional<std::uint64_t> size() const override { return head_.size() + middle_ + tail_.size(); }

 private:
  char at(std::uint64_t position) const {
    if (position < head_.size()) return head_[static_cast<std::size_t>(position)];
    position -= head_.size();
    return position < middle_ ? piece_[static_cast<std::size_t>(position % piece_.size())]
                              : tail_[static_cast<std::size_t>(position - middle_)];
  }
  std::string head_;
  std::string piece_;
  std::string tail_;
  std::string name_;
  std::uint64_t middle_;
  std::uint64_t position_ = 0;
};

/// A view that a reader has begun.
struct BegunView {
  std::size_t first_point = 0;
  std::optional<Vec3d> scanner;
  bool operator==(const BegunView&) const = default;
};

/// Keeps everything, and notes violations of PointSink's rules.
class CollectingSink final : public PointSink {
 public:
  Status begin(const ScanHeader& scan) override {
    if (begun++ > 0) complaint = "begun twice";
    header = scan;
    return refuse_begin ? Status(fail(ErrorCode::kOutOfMemory, "no room for the cloud")) : Status();
  }
  void begin_view(const ScanView& view) override {
    if (begun == 0 || !header.has_views) complaint = "a view that the header doesn't announce";
    views.push_back({points.size(), view.scanner});
  }
  Status take(std::span<const ScanPoint> batch) override {
    if (begun == 0) complaint = "points before begin";
    if (header.has_views && views.empty()) complaint = "points before their view";
    if (batch.empty()) complaint = "an empty batch";
    points.insert(points.end(), batch.begin(), batch.end());
    largest_batch = std::max(largest_batch, batch.size());
    return refuse_points ? Status(fail(ErrorCode::kOutOfMemory, "no room for the points")) : Status();
  }
  bool progress(double fraction) override {
    fractions.push_back(fraction);
    return fractions.size() != cancel_at;
  }

  ScanHeader header;
  std::vector<ScanPoint> points;
  std::vector<BegunView> views;
  std::vector<double> fractions;
  std::size_t largest_batch = 0;
  int begun = 0;
  std::string complaint;
  bool refuse_begin = false;
  bool refuse_points = false;
  std::size_t cancel_at = 0;  ///< the call of progress() that cancels, from 1
};

struct Reading {
  Expected<ScanSummary> summary;
  CollectingSink sink;

  std::vector<ScanPoint>& points() { return sink.points; }
  std::string message() const { return summary ? "" : summary.error().message(); }
  std::optional<ErrorCode> code() const {
    return summary ? std::nullopt : std::optional<ErrorCode>(summary.error().code());
  }
};

inline Reading read(ByteSource& source, std::size_t workspace = kReaderWorkspace) {
  // Filled with a pattern: a workspace is uninitialised, so a reader must not rely on zeros.
  std::vector<std::byte> memory(workspace, std::byte{0xa5});
  CollectingSink sink;
  auto summary = read_scan(source, sink, memory);
  return {summary, std::move(sink)};
}

inline Reading read(std::string_view bytes, std::string_view name = "scan", std::vector<std::size_t> pieces = {},
                    std::size_t workspace = kReaderWorkspace) {
  MemorySource source(bytes, name, std::move(pieces));
  return read(source, workspace);
}

/// The bytes of numbers in a binary file.
template <std::endian Order, class... Numbers>
std::string bytes_of(Numbers... numbers) {
  std::string out;
  const auto append = [&](auto number) {
    char copy[sizeof number];
    std::memcpy(copy, &number, sizeof number);
    if (Order != std::endian::native) std::reverse(copy, copy + sizeof copy);
    out.append(copy, sizeof copy);
  };
  (append(numbers), ...);
  return out;
}
template <class... Numbers>
std::string little(Numbers... numbers) {
  return bytes_of<std::endian::little>(numbers...);
}
template <class... Numbers>
std::string big(Numbers... numbers) {
  return bytes_of<std::endian::big>(numbers...);
}

inline std::string replaced(std::string_view text, std::string_view what, std::string_view by) {
  std::string out;
  for (std::size_t at = text.find(what); at != std::string_view::npos; at = text.find(what)) {
    out.append(text.substr(0, at)).append(by);
    text.remove_prefix(at + what.size());
  }
  return out.append(text);
}

inline bool same_point(const ScanPoint& a, const ScanPoint& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.nx == b.nx && a.ny == b.ny && a.nz == b.nz;
}
inline bool same_points(const std::vector<ScanPoint>& a, const std::vector<ScanPoint>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_point);
}

/// A simple LZF compressor: finds the longest match of 3 bytes or more in the last 8192 by brute force.
inline std::string lzf_compress(std::string_view in) {
  std::string out;
  std::string literals;
  const auto flush = [&] {
    for (std::size_t at = 0; at < literals.size(); at += 32) {
      const auto piece = literals.substr(at, 32);
      out += static_cast<char>(piece.size() - 1);
      out += piece;
    }
    literals.clear();
  };
  for (std::size_t at = 0; at < in.size();) {
    std::size_t best = 0;
    std::size_t best_distance = 0;
    for (std::size_t distance = 1; distance <= std::min<std::size_t>(at, 8192); ++distance) {
      std::size_t length = 0;
      while (length < 264 && at + length < in.size() && in[at + length] == in[at + length - distance]) ++length;
      if (length > best) {
        best = length;
        best_distance = distance;
      }
    }
    if (best < 3) {
      literals += in[at++];
      continue;
    }
    flush();
    const std::size_t code = best - 2;
    const std::size_t back = best_distance - 1;
    if (code < 7) {
      out += static_cast<char>((code << 5) | (back >> 8));
    } else {
      out += static_cast<char>((7U << 5) | (back >> 8));
      out += static_cast<char>(code - 7);
    }
    out += static_cast<char>(back & 255);
    at += best;
  }
  flush();
  return out;
}

}  // namespace plumbline::testing
