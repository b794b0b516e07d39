#pragma once
/// The bits of a point's fields, which come in separate streams.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "slicer/reader/formats/e57/e57_xml.hpp"

namespace plumbline::inline slicer {

/// Collects the streams of the wanted fields packet by packet. A packet may have more points of one field than of another, so
/// what is left of each stream is kept for the next packet.
class E57Streams {
 public:
  /// @param memory  split in two: what is kept, and what it is copied to with the next packet's bytes
  E57Streams(const E57Scan& scan, std::span<char> memory);

  /// Starts a packet: the streams follow in order, each with begin_stream().
  void begin_packet();
  /// @param slot   of E57Slot
  /// @param bytes  of the stream in this packet
  /// @returns where they go; nothing if there is no room
  std::optional<std::span<char>> begin_stream(std::size_t slot, std::size_t bytes);

  /// Points that all wanted fields have.
  std::uint64_t ready() const;
  /// Takes the next point. ready() must not be 0.
  void take(std::array<double, kE57Slots>& values);

 private:
  struct Stream {
    const char* begin = nullptr;
    const char* end = nullptr;
    unsigned used = 0;  ///< bits of the first byte

    std::uint64_t bits() const { return static_cast<std::uint64_t>(end - begin) * 8 - used; }
  };
  static std::uint64_t take_bits(Stream& stream, unsigned count);

  const E57Scan& scan_;
  std::span<char> now_, next_;
  std::size_t filled_ = 0;  ///< bytes of now_
  std::array<Stream, kE57Slots> stream_;
};

}  // namespace plumbline::inline slicer
