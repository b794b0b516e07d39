#include "hal/linux/stick/usb_sticks.hpp"

#include <libusb.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "hal/linux/stick/stick_volume.hpp"

namespace plumbline::inline hal::inline linux_board {
namespace {

bool is_mass_storage(libusb_device* device) {
  libusb_config_descriptor* configuration = nullptr;
  // Prefer the active configuration, which the kernel's driver uses. A new device may not have one yet.
  if (::libusb_get_active_config_descriptor(device, &configuration) != 0 &&
      ::libusb_get_config_descriptor(device, 0, &configuration) != 0) {
    return false;
  }
  bool is = false;
  for (int i = 0; i < configuration->bNumInterfaces; ++i) {
    const auto& interface = configuration->interface[i];
    for (int a = 0; a < interface.num_altsetting; ++a) {
      is = is || interface.altsetting[a].bInterfaceClass == LIBUSB_CLASS_MASS_STORAGE;
    }
  }
  ::libusb_free_config_descriptor(configuration);
  return is;
}

std::string place_of(libusb_device* device) {
  std::array<std::uint8_t, 7> ports{};  // USB allows 7 tiers
  const int count = ::libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  return usb_place(::libusb_get_bus_number(device), ports.data(), count);
}

}  // namespace

class UsbSticks::Context {
 public:
  explicit Context(Listener& listener) : listener_(listener) {}
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() {
    if (context_ != nullptr) {
      if (registered_) ::libusb_hotplug_deregister_callback(context_, callback_);
      ::libusb_exit(context_);
    }
    if (events_ >= 0) ::close(events_);
  }

  Status open() {
    int result = ::libusb_init(&context_);
    if (result != 0) {
      context_ = nullptr;
      return failed(result);
    }
    events_ = ::epoll_create1(EPOLL_CLOEXEC);
    const libusb_pollfd** const fds = ::libusb_get_pollfds(context_);
    for (const libusb_pollfd* const* fd = fds; fd != nullptr && *fd != nullptr; ++fd) watch((*fd)->fd, (*fd)->events);
    ::libusb_free_pollfds(fds);
    ::libusb_set_pollfd_notifiers(
        context_, [](int fd, short events, void* self) { static_cast<Context*>(self)->watch(fd, events); },
        [](int fd, void* self) { static_cast<Context*>(self)->unwatch(fd); }, this);
    result = ::libusb_hotplug_register_callback(
        context_, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, LIBUSB_HOTPLUG_ENUMERATE,
        LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, &Context::changed, this,
        &callback_);
    if (result != 0) return failed(result);
    registered_ = true;
    return {};
  }

  int descriptor() const { return events_; }

  void drain() {
    timeval none{};
    static_cast<void>(::libusb_handle_events_timeout_completed(context_, &none, nullptr));
  }

 private:
  static tl::unexpected<Error> failed(int result) {
    return fail(ErrorCode::kCannotOpen, "the stick's port: libusb: %s", ::libusb_strerror(result));
  }

  void watch(int fd, short events) const {
    epoll_event event{};
    event.events = static_cast<std::uint32_t>(events);  // EPOLLIN and EPOLLOUT are POLLIN and POLLOUT
    event.data.fd = fd;
    static_cast<void>(::epoll_ctl(events_, EPOLL_CTL_ADD, fd, &event));
  }
  void unwatch(int fd) const { static_cast<void>(::epoll_ctl(events_, EPOLL_CTL_DEL, fd, nullptr)); }

  static int changed(libusb_context* /*context*/, libusb_device* device, libusb_hotplug_event event, void* self) {
    Listener& listener = static_cast<Context*>(self)->listener_;
    if (event == LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT) {
      listener.on_departed(place_of(device));  // any kind of device: the listener knows which ones are sticks
    } else if (is_mass_storage(device)) {
      listener.on_arrived(place_of(device));
    }
    return 0;
  }

  Listener& listener_;
  libusb_context* context_ = nullptr;
  libusb_hotplug_callback_handle callback_{};
  bool registered_ = false;
  int events_ = -1;
};

UsbSticks::UsbSticks(std::unique_ptr<Context> context) : context_(std::move(context)) {}
UsbSticks::UsbSticks(UsbSticks&&) noexcept = default;
UsbSticks::~UsbSticks() = default;

Expected<UsbSticks> UsbSticks::open(Listener& listener) {
  auto context = std::make_unique<Context>(listener);
  PLUMBLINE_TRY(context->open());
  return UsbSticks(std::move(context));
}

int UsbSticks::descriptor() const { return context_->descriptor(); }
void UsbSticks::drain() { context_->drain(); }

}  // namespace plumbline::inline hal::inline linux_board
