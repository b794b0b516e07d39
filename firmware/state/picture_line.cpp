#include "firmware/state/picture_line.hpp"

#include <algorithm>
#include <string_view>

#include "firmware/io/random_id.hpp"
#include "firmware/io/text/base64.hpp"

namespace plumbline::firmware::inline state {
namespace {

/// For all of a reply but the picture.
constexpr std::size_t kRoomForTheRest = 256;
constexpr std::size_t kMostCharacters = kLongestLine - kRoomForTheRest;
static_assert(PictureLine::kMostPng == kMostCharacters / 4 * 3);

template <class Picture>
std::optional<DrawnPicture> drawn_one(const Picture& picture, std::uint32_t number) {
  if (!picture.there()) return std::nullopt;
  return DrawnPicture{picture.bytes(), picture.columns, picture.rows, std::uint32_t{Picture::kChannels}, number};
}

/// @param which  of the scans, from 0
std::optional<DrawnPicture> drawn_scan(const PrinterRecord& record, std::uint32_t which) {
  if (record.scan_pictures == nullptr || which >= record.scan_count || record.scans[which].picture == 0) return {};
  return drawn_one((*record.scan_pictures)[which], record.scans[which].picture);
}

/// @param job  0: the picture is of a scan in the list, which belongs to no job
void add_job(FixedText<120>& members, std::uint64_t job) {
  if (job != 0) members.add(", \"job\": \"%s\"", id_text(job).c_str());
}

Error too_large(std::size_t bytes) {
  return Error::format(ErrorCode::kCannotWrite, "the picture has %zu bytes, more than a line holds", bytes);
}

}  // namespace

std::optional<DrawnPicture> drawn_picture(const PrinterRecord& record, PictureName name, std::uint32_t which) {
  if (name == PictureName::kScan) return drawn_scan(record, which);
  if (record.pictures == nullptr) return std::nullopt;
  const JobPictures& pictures = *record.pictures;
  switch (name) {
    case PictureName::kPreview: return drawn_one(pictures.preview, pictures.preview_number);
    case PictureName::kIssues: return drawn_one(pictures.issues, pictures.issues_number);
    case PictureName::kPart:
      if (!pictures.part.there()) return std::nullopt;
      return DrawnPicture{.bytes = pictures.part.bytes(), .number = pictures.part_number};
    case PictureName::kProposal: return drawn_one(pictures.proposals[which], pictures.proposal_number);
    case PictureName::kScan:
    case PictureName::kLayer: break;
  }
  return drawn_one(pictures.layer(), pictures.layer_number);
}

Expected<PictureLine> PictureLine::create() {
  constexpr std::size_t kMostBytes =
      std::max({sizeof(PreviewPicture::memory), sizeof(IssuesPicture::memory), sizeof(LayerPicture::memory),
                sizeof(ProposalPicture::memory), sizeof(MaskPicture::memory)});
  auto encoder = PictureEncoder::create(kMostBytes);
  PLUMBLINE_TRY(encoder);
  PictureLine line(std::move(*encoder));
  for (Encoded& one : line.encoded_) one.base64.resize(kMostCharacters);
  line.mask_base64_.resize(kMostCharacters);
  return line;
}

Status PictureLine::write(TextSink& out, std::optional<std::uint64_t> id, PictureName name, std::uint32_t which,
                          const PrinterRecord& record) {
  const std::string_view word = kPictureWords[static_cast<std::size_t>(name)];
  const auto drawn = drawn_picture(record, name, which);
  if (!drawn) {
    return fail(ErrorCode::kBadSetting,
                "there is no picture '%.*s' now.\tThe state's \"pictures\" says which there are",
                static_cast<int>(word.size()), word.data());
  }
  const std::uint32_t number = drawn->number;
  Encoded& encoded = encoded_[static_cast<std::size_t>(name)];
  if (encoded.number != number || encoded.which != which) {
    const auto png = encoder_.encode(drawn->bytes, drawn->columns, drawn->rows, drawn->channels);
    const auto size = write_base64(png, encoded.base64);
    if (!size) return tl::unexpected<Error>(too_large(png.size()));
    encoded.size = *size;
    encoded.number = number;
    encoded.which = which;
  }
  FixedText<120> members;
  members.add("\"picture\": \"%.*s\", \"number\": %u", static_cast<int>(word.size()), word.data(), number);
  if (name == PictureName::kScan) members.add(", \"scan\": %u", which + 1);
  if (name == PictureName::kProposal) members.add(", \"proposal\": %u", which);
  if (name != PictureName::kScan) add_job(members, record.job_id);
  return write_data_line(out, id, members.view(), "png", {encoded.base64.data(), encoded.size});
}

Status PictureLine::write_kept(TextSink& out, std::optional<std::uint64_t> id, const KeptPrints& prints,
                               std::uint32_t print) {
  std::array<std::byte, kMostPng> png;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const auto got = prints.read(print, KeptPrints::Part::kPreview, 0, png);
  PLUMBLINE_TRY(got);
  const auto size = write_base64(std::span(png).first(got->bytes), mask_base64_);
  if (!size || got->bytes < got->size) return tl::unexpected<Error>(too_large(static_cast<std::size_t>(got->size)));
  FixedText<64> members;
  members.add("\"picture\": \"preview\", \"print\": %u", print);
  return write_data_line(out, id, members.view(), "png", {mask_base64_.data(), *size});
}

Status PictureLine::write_mask(TextSink& out, std::optional<std::uint64_t> id, std::uint32_t layer, std::uint64_t job) {
  if (!mask_->there()) return fail(ErrorCode::kBadSetting, "\"x\" and \"y\" are beyond the mask");
  const auto png = encoder_.encode(mask_->bytes(), mask_->columns, mask_->rows, MaskPicture::kChannels);
  const auto size = write_base64(png, mask_base64_);
  if (!size) return tl::unexpected<Error>(too_large(png.size()));
  FixedText<120> members;
  members.add("\"layer\": %u", layer);
  add_job(members, job);
  return write_data_line(out, id, members.view(), "png", {mask_base64_.data(), *size});
}

}  // namespace plumbline::firmware::inline state
