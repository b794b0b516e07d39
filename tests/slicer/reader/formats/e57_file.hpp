#pragma once
/// Writes E57 files bit by bit, without any code of the reader.

#include <bit>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "tests/slicer/reader/scan_fixture.hpp"

namespace plumbline::testing {

struct E57Column {
  std::string name;        ///< "cartesianX"
  std::string attributes;  ///< of its element in the prototype
  int bits = 0;
  std::vector<std::uint64_t> values;  ///< the lowest `bits` bits of each
};

inline E57Column float_column(const std::string& name, const std::vector<float>& values) {
  E57Column column{name, R"(type="Float" precision="single")", 32, {}};
  for (const float value : values) column.values.push_back(std::bit_cast<std::uint32_t>(value));
  return column;
}
inline E57Column double_column(const std::string& name, const std::vector<double>& values) {
  E57Column column{name, R"(type="Float")", 64, {}};
  for (const double value : values) column.values.push_back(std::bit_cast<std::uint64_t>(value));
  return column;
}
/// @param more  attributes
inline E57Column integer_column(const std::string& name, const char* type, std::int64_t low, std::int64_t high,
                                const std::vector<std::int64_t>& values, const std::string& more = "") {
  E57Column column{name, "", 0, {}};
  column.attributes = std::string("type=\"") + type + "\" minimum=\"" + std::to_string(low) + "\" maximum=\"" +
                      std::to_string(high) + "\" " + more;
  for (std::uint64_t range = static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low); range > 0;
       range /= 2) {
    ++column.bits;
  }
  for (const std::int64_t value : values) {
    column.values.push_back(static_cast<std::uint64_t>(value) - static_cast<std::uint64_t>(low));
  }
  return column;
}

struct E57TestScan {
  std::vector<E57Column> columns = {};
  std::string pose = {};     ///< elements in <pose>
  std::size_t packet = 200;  ///< bits of a column in a packet; the columns differ by up to `uneven` bits
  std::size_t uneven = 0;
  std::int64_t more = 0;  ///< points declared beyond those that there are
};

inline std::uint32_t slow_crc32c(std::string_view bytes) {
  std::uint32_t rest = 0xffffffff;
  for (const char byte : bytes) {
    rest ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) rest = (rest & 1U) != 0 ? (rest >> 1) ^ 0x82f63b78U : rest >> 1;
  }
  return ~rest;
}

/// The bytes of a file, of which only the payload of the pages is written.
class E57File {
 public:
  /// Called with the XML before it is written.
  std::function<std::string(std::string)> change_xml = [](std::string xml) { return xml; };

  std::string bytes(const std::vector<E57TestScan>& scans) {
    payload_.assign(48, '\0');
    std::string list;
    for (const E57TestScan& scan : scans) list += section(scan);
    const std::string xml = change_xml(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
        "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\" xmlns:nor=\"http://www.libe57.org/E57_NOR_surface_"
        "normals.txt\"><formatName type=\"String\"><![CDATA[ASTM E57 3D Imaging Data File]]></formatName>\n<data3D "
        "type=\"Vector\" allowHeterogeneousChildren=\"1\">\n" +
        list +
        "</data3D>\n<images2D type=\"Vector\" allowHeterogeneousChildren=\"1\"><vectorChild type=\"Structure\">"
        "<pose><translation><x>9</x></translation></pose></vectorChild></images2D></e57Root>\n");
    const std::uint64_t xml_at = physical(payload_.size());
    payload_ += xml;
    const std::uint64_t pages = (payload_.size() + 1019) / 1020;
    payload_.replace(0, 48,
                     "ASTM-E57" + little(1U, 0U, pages * 1024, xml_at, std::uint64_t{xml.size()}, std::uint64_t{1024}));
    payload_.resize(static_cast<std::size_t>(pages) * 1020, '\0');
    return paged(payload_);
  }

  static std::string paged(std::string_view payload) {
    std::string out;
    for (std::size_t at = 0; at < payload.size(); at += 1020) {
      const auto page = payload.substr(at, 1020);
      out.append(page).append(big(slow_crc32c(page)));
    }
    return out;
  }
  /// The opposite, for tests that change a byte and not its checksum.
  static std::string unpaged(std::string_view file) {
    std::string out;
    for (std::size_t at = 0; at < file.size(); at += 1024) out.append(file.substr(at, 1020));
    return out;
  }

 private:
  static std::uint64_t physical(std::uint64_t logical) { return logical / 1020 * 1024 + logical % 1020; }

  std::string section(const E57TestScan& scan) {
    while (payload_.size() % 4 != 0) payload_ += '\0';
    const std::size_t start = payload_.size();
    payload_ += std::string(32, '\0');
    const std::uint64_t data = payload_.size();
    payload_ += std::string(little(std::uint8_t{2}, std::uint8_t{0}, std::uint16_t{7})) + "rest";  // an empty packet
    std::vector<std::string> bits;
    for (const E57Column& column : scan.columns) {
      std::string& all = bits.emplace_back();
      for (const std::uint64_t value : column.values) {
        for (int bit = 0; bit < column.bits; ++bit) all += static_cast<char>(value >> bit & 1U);
      }
      while (all.size() % 8 != 0) all += '\0';
    }
    std::vector<std::size_t> done(bits.size(), 0);
    for (bool more = true; more;) {
      more = false;
      std::string lengths, streams;
      for (std::size_t c = 0; c < bits.size(); ++c) {
        std::string stream;
        const std::size_t most =
            (scan.packet + (scan.uneven > 0 ? (c * 37 + done[c] / 8 * 11) % scan.uneven : 0)) / 8 * 8;
        const std::size_t stop = std::min(bits[c].size(), done[c] + most);
        for (; done[c] < stop; done[c] += 8) {
          unsigned byte = 0;
          for (unsigned b = 0; b < 8; ++b) byte |= static_cast<unsigned>(bits[c][done[c] + b]) << b;
          stream += static_cast<char>(byte);
        }
        more = more || done[c] < bits[c].size();
        lengths += little(static_cast<std::uint16_t>(stream.size()));
        streams += stream;
      }
      std::string packet = little(static_cast<std::uint16_t>(bits.size())) + lengths + streams;
      while (packet.size() % 4 != 0) packet += '\0';
      payload_ += little(std::uint8_t{1}, std::uint8_t{0}, static_cast<std::uint16_t>(packet.size() + 3)) + packet;
    }
    payload_ += little(std::uint8_t{0}, std::uint8_t{0}, std::uint16_t{15}) + std::string(12, '\0');  // an index
    payload_.replace(
        start, 32, little(std::uint64_t{1}, std::uint64_t{payload_.size() - start}, physical(data), std::uint64_t{0}));
    const auto points = static_cast<std::int64_t>(scan.columns.front().values.size()) + scan.more;
    std::string xml = "<vectorChild type=\"Structure\"><guid type=\"String\"><![CDATA[{3F2}]]></guid>";
    if (!scan.pose.empty()) xml += "<pose type=\"Structure\">" + scan.pose + "</pose>";
    xml += "<points type=\"CompressedVector\" fileOffset=\"" + std::to_string(physical(start)) + "\" recordCount=\"" +
           std::to_string(points) + "\"><prototype type=\"Structure\">";
    for (const E57Column& column : scan.columns) xml += "<" + column.name + " " + column.attributes + "/>\n";
    return xml +
           "</prototype><codecs type=\"Vector\" allowHeterogeneousChildren=\"1\"></codecs></points></vectorChild>\n";
  }

  std::string payload_;
};

}  // namespace plumbline::testing
