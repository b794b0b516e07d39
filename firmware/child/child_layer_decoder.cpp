#include "firmware/child/child_layer_decoder.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "firmware/child/answer_check.hpp"
#include "firmware/io/interrupt.hpp"

namespace plumbline::firmware {

Status ChildLayerDecoder::prepare(const PrintGrid& grid, bool shows_grey, Arena& arena) {
  constexpr std::size_t kPage = SharedMemory::kPage;
  const std::size_t bytes = BitImage::words_needed(grid.columns, grid.rows) * sizeof(std::uint64_t);
  const std::size_t runs = shows_grey ? GreyRuns::runs_needed(grid.columns, grid.rows) : 0;
  const auto room = arena.take_top<std::byte>(bytes + runs * sizeof(GreyRun) + 2 * kPage, "masks");
  PLUMBLINE_TRY(room);
  // Whole pages, so that none of what lies before or after it is on them.
  const auto at = static_cast<std::size_t>(room->data() - child_.arena_block().data());
  const auto whole = child_.arena_block().subspan((at + kPage - 1) / kPage * kPage);
  mask_ = whole.first(bytes);
  runs_ = {reinterpret_cast<const GreyRun*>(whole.data() + bytes), runs};
  return {};
}

Status ChildLayerDecoder::decode(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn,
                                 BitImage out, GreyRuns& greys) {
  using HostClock = std::chrono::steady_clock;
  PLUMBLINE_TRY(begin(file, name, layer, turn));
  auto until = HostClock::now() + patience_.layer;
  for (bool asked_to_end = false; HostClock::now() < until;) {
    const auto done = finish(std::chrono::milliseconds(100), out, greys);
    PLUMBLINE_TRY(done);
    if (*done) return {};
    if (!asked_to_end && interrupted()) {
      asked_to_end = true;
      until = std::min(until, HostClock::now() + patience_.last);
    }
  }
  return tl::unexpected<Error>(give_up());
}

Status ChildLayerDecoder::begin(int file, std::string_view name, const ArchiveLayer& layer, const MaskTurn& turn) {
  ScanRequest request;
  request.name.add("%.*s", static_cast<int>(name.size()), name.data());
  request.settings.placement.printer = printer_;
  request.archive = {ArchiveRequest::Ask::kLayer, layer, turn,
                     static_cast<std::uint64_t>(mask_.data() - child_.arena_block().data()), !runs_.empty()};
  name_ = request.name;
  number_ = layer.number;
  return child_.start(request, file);
}

Expected<bool> ChildLayerDecoder::finish(std::chrono::milliseconds patience, BitImage out, GreyRuns& greys) {
  const auto ended = child_.wait(patience);
  PLUMBLINE_TRY(ended);
  if (!*ended) return false;
  if (**ended != 0) return tl::unexpected<Error>(broke("failed"));
  const ScanAnswer answer = child_.answer();
  constexpr std::array kErrors = {ErrorCode::kCannotRead, ErrorCode::kMalformed, ErrorCode::kUnsupported,
                                  ErrorCode::kOutOfMemory};
  if (answer.kind == ScanAnswer::kRefused) return child_error(answer, kErrors);
  if (answer.kind != ScanAnswer::kLayer) return fail(ErrorCode::kMalformed, "%s: no answer", name_.c_str());
  std::memcpy(out.words().data(), mask_.data(), mask_.size());
  for (std::uint32_t r = 0; r < out.rows(); ++r) out.row(r).back() &= out.last_word_mask();
  PLUMBLINE_TRY(take_checked_greys(runs_, answer.greys, out.columns(), out.rows(), greys));
  return true;
}

Error ChildLayerDecoder::give_up() {
  child_.kill(patience_.end);
  for (;;) {
    const auto ended = child_.wait(patience_.end);
    if (!ended) return ended.error();
    if (*ended) return broke("made no progress");
  }
}

Error ChildLayerDecoder::broke(const char* how) const {
  return Error::format(ErrorCode::kMalformed, "%s: layer %llu: decoding it %s", name_.c_str(),
                       static_cast<unsigned long long>(number_), how);
}

}  // namespace plumbline::firmware
