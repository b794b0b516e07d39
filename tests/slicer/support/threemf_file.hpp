#pragma once
/// Writes 3MF files part by part, without any code of the reader.

#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/slicer/reader/scan_fixture.hpp"
#include "tests/slicer/support/deflated.hpp"

namespace plumbline::testing {

/// How a part is packed and what its header says.
struct ZipPart {
  std::string name;
  std::string content;
  bool deflated = true;
  bool sizes_follow = false;  ///< in a descriptor behind the data, not in the header
  bool descriptor_is_signed = true;
  bool long_sizes = false;           ///< 64 bits: in an extra field, or in the descriptor
  std::uint16_t flags = 0;           ///< more flags
  std::uint16_t method = 0;          ///< another method than the content's; 0: the right one
  std::uint32_t checksum_error = 0;  ///< added to the checksum
};

inline std::string zip_of(const std::vector<ZipPart>& parts) {
  std::string zip;
  std::string directory;
  for (const ZipPart& part : parts) {
    const std::string packed = part.deflated ? deflated(part.content, -15) : part.content;
    const auto checksum = static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(part.content.data()),
                                                           static_cast<uInt>(part.content.size()))) +
                          part.checksum_error;
    const auto packed_size = static_cast<std::uint32_t>(packed.size());
    const auto size = static_cast<std::uint32_t>(part.content.size());
    const auto flags = static_cast<std::uint16_t>(part.flags | (part.sizes_follow ? 8U : 0U));
    const auto method = part.method != 0 ? part.method : static_cast<std::uint16_t>(part.deflated ? 8 : 0);
    const auto offset = static_cast<std::uint32_t>(zip.size());
    const auto name_size = static_cast<std::uint16_t>(part.name.size());
    const bool extra = part.long_sizes && !part.sizes_follow;
    zip += little(std::uint32_t{0x04034b50}, std::uint16_t{20}, flags, method, std::uint32_t{0});
    if (part.sizes_follow) {
      zip += little(std::uint32_t{0}, std::uint32_t{0}, std::uint32_t{0});
    } else if (extra) {
      zip += little(checksum, std::uint32_t{0xffffffff}, std::uint32_t{0xffffffff});
    } else {
      zip += little(checksum, packed_size, size);
    }
    zip += little(name_size, static_cast<std::uint16_t>(extra ? 20 : 0)) + part.name;
    if (extra) zip += little(std::uint16_t{1}, std::uint16_t{16}, std::uint64_t{size}, std::uint64_t{packed_size});
    zip += packed;
    if (part.sizes_follow) {
      if (part.descriptor_is_signed) zip += little(std::uint32_t{0x08074b50});
      zip += little(checksum);
      zip += part.long_sizes ? little(std::uint64_t{packed_size}, std::uint64_t{size}) : little(packed_size, size);
    }
    directory += little(std::uint32_t{0x02014b50}, std::uint16_t{20}, std::uint16_t{20}, flags, method,
                        std::uint32_t{0}, checksum, packed_size, size, name_size, std::uint16_t{0}, std::uint16_t{0},
                        std::uint16_t{0}, std::uint16_t{0}, std::uint32_t{0}, offset) +
                 part.name;
  }
  const auto count = static_cast<std::uint16_t>(parts.size());
  const auto start = static_cast<std::uint32_t>(zip.size());
  return zip + directory +
         little(std::uint32_t{0x06054b50}, std::uint16_t{0}, std::uint16_t{0}, count, count,
                static_cast<std::uint32_t>(directory.size()), start, std::uint16_t{0});
}

inline const std::string kModelStart =
    R"(<?xml version="1.0" encoding="UTF-8"?>)"
    "\n"
    R"(<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" )"
    R"(xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06">)"
    "\n";

/// @param inner  elements of the model
inline std::string model_of(const std::string& inner) { return kModelStart + inner + "</model>\n"; }

inline std::string relations_to(const std::string& target) {
  return R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">)"
         R"(<Relationship Target=")" +
         target +
         R"(" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";
}

/// As most programs write it.
inline std::string threemf_with(const std::string& model) {
  return zip_of({{"[Content_Types].xml", "<Types/>"},
                 {"_rels/.rels", relations_to("/3D/3dmodel.model")},
                 {"3D/3dmodel.model", model}});
}

}  // namespace plumbline::testing
