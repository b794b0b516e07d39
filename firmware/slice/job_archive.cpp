#include "firmware/slice/job_archive.hpp"

#include <utility>

#include "firmware/io/text/fixed_text.hpp"
#include "slicer/reader/stream/words.hpp"

namespace plumbline::firmware {

bool is_sl1_name(std::string_view path) { return has_ending(path, ".sl1") || has_ending(path, ".sl1s"); }

Expected<JobArchive> JobArchive::open(const std::string& path) {
  auto zip = ZipWriter::create(path);
  PLUMBLINE_TRY(zip);
  return JobArchive(std::move(*zip));
}

Status JobArchive::write_layer(std::uint32_t layer, std::span<const std::byte> png) {
  FixedText<32> name;
  name.add("%s%05u.png", kSl1Layer, layer);
  return zip_.add(name.c_str(), png, ZipWriter::Packing::kStore);
}

Status JobArchive::write_thumbnail(ThumbnailSize size, std::span<const std::byte> png) {
  FixedText<64> name;
  name.add("thumbnail/thumbnail%ux%u.png", size.columns, size.rows);
  return zip_.add(name.c_str(), png, ZipWriter::Packing::kStore);
}

Status JobArchive::finish(const Sl1Job& job) {
  const auto bytes = [](const std::string& text) { return std::as_bytes(std::span(text)); };
  PLUMBLINE_TRY(zip_.add("config.ini", bytes(sl1_config(job)), ZipWriter::Packing::kDeflate));
  PLUMBLINE_TRY(zip_.add("prusaslicer.ini", bytes(sl1_prusaslicer(job)), ZipWriter::Packing::kDeflate));
  return zip_.finish();
}

}  // namespace plumbline::firmware
