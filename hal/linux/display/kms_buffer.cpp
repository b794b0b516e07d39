#include "hal/linux/display/kms_buffer.hpp"

#include <drm_fourcc.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

#include "hal/linux/display/kms_search.hpp"

namespace plumbline::inline hal::inline linux_board::kms {

Expected<Buffer> Buffer::create(int card, std::uint32_t width, std::uint32_t height, std::uint32_t bits) {
  const bool narrow = bits == 16;
  drm_mode_create_dumb create{};
  create.width = width;
  create.height = height;
  create.bpp = narrow ? 16 : 32;
  if (::drmIoctl(card, DRM_IOCTL_MODE_CREATE_DUMB, &create) != 0) return panel_failed("can't create a buffer", errno);
  Buffer buffer;
  buffer.data_.card = card;
  buffer.data_.handle = create.handle;
  buffer.data_.pitch = create.pitch / sizeof(std::uint32_t);
  const std::uint32_t handles[4] = {create.handle, 0, 0, 0};
  const std::uint32_t pitches[4] = {create.pitch, 0, 0, 0};
  const std::uint32_t offsets[4] = {0, 0, 0, 0};
  const std::uint32_t format = narrow ? DRM_FORMAT_RGB565 : DRM_FORMAT_XRGB8888;
  if (::drmModeAddFB2(card, width, height, format, handles, pitches, offsets, &buffer.data_.frame, 0) != 0) {
    return panel_failed(narrow ? "does not take RGB565" : "does not take XRGB8888", errno);
  }
  drm_mode_map_dumb map{};
  map.handle = create.handle;
  if (::drmIoctl(card, DRM_IOCTL_MODE_MAP_DUMB, &map) != 0) return panel_failed("can't map its buffer", errno);
  void* const mapped = ::mmap(nullptr, static_cast<std::size_t>(create.size), PROT_READ | PROT_WRITE, MAP_SHARED, card,
                              static_cast<off_t>(map.offset));
  if (mapped == MAP_FAILED) return panel_failed("can't map its buffer", errno);
  buffer.data_.pixels = {static_cast<std::uint32_t*>(mapped),
                         static_cast<std::size_t>(create.size) / sizeof(std::uint32_t)};
  std::fill(buffer.data_.pixels.begin(), buffer.data_.pixels.end(), 0U);
  return buffer;
}

Buffer::~Buffer() {
  if (!data_.pixels.empty()) ::munmap(data_.pixels.data(), data_.pixels.size_bytes());
  if (data_.frame != 0) static_cast<void>(::drmModeRmFB(data_.card, data_.frame));
  if (data_.handle == 0) return;
  drm_mode_destroy_dumb destroy{};
  destroy.handle = data_.handle;
  static_cast<void>(::drmIoctl(data_.card, DRM_IOCTL_MODE_DESTROY_DUMB, &destroy));
}

}  // namespace plumbline::inline hal::inline linux_board::kms
