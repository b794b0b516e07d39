#include "hal/linux/display/kms_screen.hpp"

#include <cerrno>
#include <utility>

#include "hal/linux/display/kms_buffer.hpp"
#include "hal/linux/display/kms_output.hpp"

namespace plumbline::inline hal::inline linux_board {

using namespace kms;

namespace {

DisplaySettings display_of(const ScreenSettings& settings) {
  DisplaySettings display;
  display.card = settings.card;
  display.connector = settings.connector;
  return display;
}

}  // namespace

/// Members are destroyed in reverse order: first the output restores the former picture.
class KmsScreen::Device {
 public:
  explicit Device(FoundPanel panel) : panel_(std::move(panel)), output_(panel_) {}

  Status acquire(std::uint32_t bits) {
    PLUMBLINE_TRY(output_.acquire(0));
    auto created = Buffer::create(panel_.card.get(), panel_.mode.hdisplay, panel_.mode.vdisplay, bits);
    PLUMBLINE_TRY(created);
    buffer_ = std::move(*created);
    const int result = output_.set_mode(buffer_.frame());
    if (result != 0) return panel_failed("for people refuses its mode", -result);
    return {};
  }
  Status send() {
    const int result = ::drmModeDirtyFB(panel_.card.get(), buffer_.frame(), nullptr, 0);
    // A panel that is scanned out all the time needs no sending, and its driver says so.
    if (result == 0 || result == -ENOSYS || result == -EINVAL || result == -EOPNOTSUPP) return {};
    return panel_failed("for people does not take its picture", -result);
  }
  const Buffer& buffer() const { return buffer_; }

 private:
  FoundPanel panel_;
  Buffer buffer_;
  Output output_;
};

KmsScreen::KmsScreen(std::unique_ptr<Device> device) : device_(std::move(device)) {}
KmsScreen::KmsScreen(KmsScreen&&) noexcept = default;
KmsScreen::~KmsScreen() = default;

Expected<KmsScreen> KmsScreen::open(const ScreenSettings& settings, std::uint32_t width, std::uint32_t height,
                                    const std::optional<CardInUse>& beside) {
  auto found = find_panel(display_of(settings), width, height, beside);
  PLUMBLINE_TRY(found);
  auto device = std::make_unique<Device>(std::move(*found));
  PLUMBLINE_TRY(device->acquire(settings.bits));
  return KmsScreen(std::move(device));
}

Expected<DisplayFinding> KmsScreen::examine(const ScreenSettings& settings, std::uint32_t width, std::uint32_t height) {
  return KmsPanel::examine(display_of(settings), width, height);
}

std::span<std::byte> KmsScreen::memory() const { return std::as_writable_bytes(device_->buffer().pixels()); }
std::size_t KmsScreen::pitch() const { return device_->buffer().pitch() * sizeof(std::uint32_t); }
Status KmsScreen::send() { return device_->send(); }

}  // namespace plumbline::inline hal::inline linux_board
