#include "firmware/state/picture_line.hpp"

#include <algorithm>
#include <string_view>

namespace plumbline {
namespace {

/// For all of a reply but the picture.
constexpr std::size_t kRoomForTheRest = 256;
constexpr std::size_t kMostCharacters = kLongestLine - kRoomForTheRest;

/// @returns characters written; none: they are more than `out` holds
std::optional<std::size_t> write_base64(std::span<const std::byte> bytes, std::span<char> out) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t size = (bytes.size() + 2) / 3 * 4;
  if (size > out.size()) return std::nullopt;
  const auto byte = [&](std::size_t i) { return i < bytes.size() ? std::to_integer<unsigned>(bytes[i]) : 0U; };
  for (std::size_t i = 0, at = 0; i < bytes.size(); i += 3, at += 4) {
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (std::size_t k = 0; k < 4; ++k) out[at + k] = kDigits[three >> (18 - 6 * k) & 63U];
    if (i + 1 >= bytes.size()) out[at + 2] = '=';
    if (i + 2 >= bytes.size()) out[at + 3] = '=';
  }
  return size;
}

}  // namespace

Expected<PictureLine> PictureLine::create() {
  constexpr std::size_t kMostBytes = std::max(sizeof(PreviewPicture::memory), sizeof(LayerPicture::memory));
  auto encoder = SmallPngEncoder::create(kMostBytes, std::max(PreviewPicture::kMostRows, LayerPicture::kMostRows));
  PLUMBLINE_TRY(encoder);
  PictureLine line(std::move(*encoder));
  for (Encoded& one : line.encoded_) one.base64.resize(kMostCharacters);
  return line;
}

Status PictureLine::write(TextSink& out, std::optional<std::uint64_t> id, PictureName name,
                          const PrinterRecord& record) {
  const std::string_view word = kPictureWords[static_cast<std::size_t>(name)];
  const JobPictures* const pictures = record.pictures;
  const bool is_preview = name == PictureName::kPreview;
  const bool there = pictures != nullptr && (is_preview ? pictures->preview.there() : pictures->layer().there());
  if (!there) {
    return fail(ErrorCode::kBadSetting,
                "there is no picture '%.*s' now.\tThe state's \"pictures\" says which there are",
                static_cast<int>(word.size()), word.data());
  }
  const std::uint32_t number = is_preview ? pictures->preview_number : pictures->layer_number;
  Encoded& encoded = encoded_[static_cast<std::size_t>(name)];
  if (encoded.number != number) {
    const auto png = is_preview ? encoder_.encode(pictures->preview.bytes(), pictures->preview.columns,
                                                  pictures->preview.rows, PreviewPicture::kChannels)
                                : encoder_.encode(pictures->layer().bytes(), pictures->layer().columns,
                                                  pictures->layer().rows, LayerPicture::kChannels);
    const auto size = write_base64(png, encoded.base64);
    if (!size) return fail(ErrorCode::kCannotWrite, "the picture has %zu bytes, more than a line holds", png.size());
    encoded.size = *size;
    encoded.number = number;
  }
  FixedText<kRoomForTheRest> head;
  head.add("{\"type\": \"reply\", \"id\": ");
  if (id) {
    head.add("%llu", static_cast<unsigned long long>(*id));
  } else {
    head.add("null");
  }
  head.add(", \"ok\": true, \"picture\": \"%.*s\", \"number\": %u, \"png\": \"", static_cast<int>(word.size()),
           word.data(), number);
  PLUMBLINE_TRY(out.write(head.view()));
  PLUMBLINE_TRY(out.write(std::string_view(encoded.base64.data(), encoded.size)));
  return out.write("\"}\n");
}

}  // namespace plumbline
