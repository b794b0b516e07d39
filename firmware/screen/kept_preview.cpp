#include "firmware/screen/kept_preview.hpp"

#include <utility>

#include "firmware/state/picture_line.hpp"

namespace plumbline::firmware::inline screen {

Expected<KeptPreview> KeptPreview::create() {
  auto decoder = PictureDecoder::create();
  PLUMBLINE_TRY(decoder);
  return KeptPreview(std::move(*decoder));
}

// A print is kept with a preview only if its PNG fits a line.
KeptPreview::KeptPreview(PictureDecoder decoder)
    : decoder_(std::move(decoder)), file_(PictureLine::kMostPng), picture_(1) {}

const PreviewPicture* KeptPreview::of(const KeptPrints& prints, std::uint32_t number) {
  PreviewPicture& picture = picture_[0];
  if (number != number_) {
    number_ = number;
    picture.clear();
    const auto got = prints.read(number, KeptPrints::Part::kPreview, 0, file_);
    if (!got || got->bytes != got->size) return nullptr;
    const auto size = decoder_.decode(std::span(file_).first(got->bytes), PreviewPicture::kChannels,
                                      {PreviewPicture::kMostColumns, PreviewPicture::kMostRows}, picture.memory);
    if (!size) return nullptr;
    picture.columns = size->columns;
    picture.rows = size->rows;
  }
  return picture.there() ? &picture : nullptr;
}

}  // namespace plumbline::firmware::inline screen
