#include "hal/sim/plant/cured_part.hpp"

#include <algorithm>
#include <cassert>

#include "slicer/core/bit_spans.hpp"

namespace plumbline::inline hal::inline sim {
namespace {

bool same_height(ZPosition a, ZPosition b) { return a - b < 1_um && b - a < 1_um; }

void put_number(std::vector<std::uint8_t>& bytes, std::size_t number) {
  for (; number >= 128; number /= 128) bytes.push_back(static_cast<std::uint8_t>(number % 128 + 128));
  bytes.push_back(static_cast<std::uint8_t>(number));
}

std::size_t take_number(const std::uint8_t*& at) {
  std::size_t number = 0;
  unsigned shift = 0;
  for (; *at >= 128; ++at, shift += 7) number |= static_cast<std::size_t>(*at - 128) << shift;
  return number | static_cast<std::size_t>(*at++) << shift;
}

}  // namespace

CuredPart::CuredPart(std::uint32_t columns, std::uint32_t rows, double pitch_x_mm, double pitch_y_mm,
                     const PeelSettings& peel, bool keep)
    : columns_(columns),
      rows_(rows),
      keep_(keep),
      hanging_({.columns = columns,
                .rows = rows,
                .pitch_x_mm = pitch_x_mm,
                .pitch_y_mm = pitch_y_mm,
                .peel = peel,
                .remember = keep}),
      light_(columns, rows),
      open_(BitImage::words_needed(columns, rows), 0),
      asked_(open_.size(), 0),
      before_(keep ? open_.size() : 0, 0) {}

std::uint32_t CuredPart::layer_at(ZPosition z) const {
  const auto count = static_cast<std::uint32_t>(layers_.size());
  return count > 0 && same_height(layers_.back().z, z) ? count - 1 : count;
}

void CuredPart::expose(ZPosition z, ConstBitImage mask, TimePoint began, TimePoint ended, Dose asked, Dose dose,
                       const Resin& resin, std::span<const GreyRun> greys) {
  assert(mask.columns() == columns_ && mask.rows() == rows_);
  bool goes_on = false;  // the mask has changed under the lamp
  if (layer_at(z) == layers_.size()) {
    if (!layers_.empty() && keep_) pack_open_layer();
    light_.clear();
    layers_.push_back({.z = z, .began = began, .ended = ended, .exposures = 0, .asked = {}, .dose = Dose(0)});
    if (begins_a_part()) hanging_.clean_film();
    shaded_ = !hanging_.film_is_clean();
  } else {
    goes_on = began == began_;
  }
  began_ = began;
  CuredLayer& layer = layers_.back();
  layer.ended = ended;
  ++layer.exposures;
  // What an interruption left of an exposure was asked for before.
  if (light_.add(mask, greys, dose) && !goes_on) layer.asked = layer.asked + asked;
  layer.dose = layer.dose + dose;
  layer.depth_mm = resin.cure_depth_mm(layer.dose);
  light_.combine(image(open_), open_greys_);
  if (shaded_) {
    asked_ = open_;
    const auto film = hanging_.film().words();
    for (std::size_t i = 0; i < open_.size(); ++i) open_[i] &= ~film[i];
  }
  judge_greys(resin);
  layer.pixels = 0;
  for (const std::uint64_t word : open_) {
    if (word != 0) layer.pixels += count_ones(word);
  }
}

void CuredPart::judge_greys(const Resin& resin) {
  const BitImage open = image(open_), asked = image(asked_);
  for (const GreyRun& run : open_greys_) {
    const bool cured = layers_.back().dose * (run.level / double{kFullLevel}) > resin.critical;
    const std::uint32_t row = run.pixel / columns_, begin = run.pixel % columns_, end = begin + run.count;
    if (!shaded_) {
      fill(open, row, begin, end, cured);
      continue;
    }
    fill(asked, row, begin, end, cured);
    const auto line = open.row(row);
    const auto film = hanging_.film().row(row);
    for_each_word(begin, end, [&](std::uint32_t w, std::uint64_t bits) {
      line[w] = cured ? line[w] | (bits & ~film[w]) : line[w] & ~bits;
    });
  }
}

// For each word that differs from the layer before: the number of equal words to skip (7 bits a byte, low first; the high bit means
// that more follow), a bit for each byte of the difference that is not 0, and those bytes. A layer ends with a skip past its last
// word.
void CuredPart::pack_open_layer() {
  if (layers_.back().depth_mm <= 0) std::fill(open_.begin(), open_.end(), 0);
  std::size_t next = 0;
  for (std::size_t i = 0; i < open_.size(); ++i) {
    const std::uint64_t difference = open_[i] ^ before_[i];
    if (difference == 0) continue;
    put_number(packed_, i - next);
    next = i + 1;
    const std::size_t which = packed_.size();
    packed_.push_back(0);
    for (unsigned b = 0; b < 8; ++b) {
      const auto byte = static_cast<std::uint8_t>(difference >> (8 * b));
      if (byte == 0) continue;
      packed_[which] = static_cast<std::uint8_t>(packed_[which] | (1U << b));
      packed_.push_back(byte);
    }
  }
  put_number(packed_, open_.size() - next);
  std::copy(open_.begin(), open_.end(), before_.begin());
  pack_open_greys();
}

// The number of runs, and for each of them the pixels since the end of the one before, its own pixels and its level.
void CuredPart::pack_open_greys() {
  put_number(packed_greys_, open_greys_.size());
  std::uint32_t next = 0;
  for (const GreyRun& run : open_greys_) {
    put_number(packed_greys_, run.pixel - next);
    put_number(packed_greys_, run.count);
    packed_greys_.push_back(run.level);
    next = run.end();
  }
}

bool CuredPart::begins_a_part() const { return layers_.size() == 1 || layers_.back().z <= layers_.front().z; }

void CuredPart::complete_layer(std::uint32_t number, double height_mm, bool on_part) {
  CuredLayer& layer = layers_.back();
  layer.height_mm = height_mm;
  if (begins_a_part()) hanging_.begin(on_part);
  if (layer.depth_mm <= 0) {
    hanging_.skip_layer(number);
  } else {
    const ConstBitImage asked(shaded_ ? asked_ : open_, columns_, rows_);
    hanging_.add_layer(number, height_mm, layer.depth_mm, image(open_), asked);
  }
}

void CuredPart::for_each_layer(const std::function<void(const CuredLayer&, ConstBitImage)>& visit) const {
  for_each_lit_layer([&](const CuredLayer& layer, ConstBitImage mask, auto) { visit(layer, mask); });
}

void CuredPart::for_each_lit_layer(const LitVisit& visit) const {
  assert(keep_);
  if (layers_.empty()) return;
  std::vector<std::uint64_t> words(open_.size(), 0);
  std::vector<std::uint64_t> stayed(open_.size());
  std::vector<GreyRun> greys;
  const auto show = [&](std::size_t k) {
    if (!hanging_.any_torn()) return visit(layers_[k], image(words), greys);
    stayed = words;
    hanging_.remove_lost(k, image(stayed));
    visit(layers_[k], image(stayed), stayed == words ? std::span<const GreyRun>(greys) : std::span<const GreyRun>());
  };
  const std::uint8_t* at = packed_.data();
  const std::uint8_t* grey_at = packed_greys_.data();
  for (std::size_t k = 0; k + 1 < layers_.size(); ++k) {
    for (std::size_t i = take_number(at); i < words.size(); i += 1 + take_number(at)) {
      const unsigned which = *at++;
      for (unsigned b = 0; b < 8; ++b) {
        if ((which >> b & 1U) != 0) words[i] ^= static_cast<std::uint64_t>(*at++) << (8 * b);
      }
    }
    greys.resize(take_number(grey_at));
    std::uint32_t next = 0;
    for (GreyRun& run : greys) {
      run.pixel = next + static_cast<std::uint32_t>(take_number(grey_at));
      run.count = static_cast<std::uint16_t>(take_number(grey_at));
      run.level = *grey_at++;
      next = run.end();
    }
    show(k);
  }
  words = open_;
  greys = open_greys_;
  if (layers_.back().depth_mm <= 0) image(words).clear();
  show(layers_.size() - 1);
}

}  // namespace plumbline::inline hal::inline sim
