#include "hal/linux/display/kms_search.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

namespace plumbline::inline hal::inline linux_board::kms {
namespace {

std::string connector_name(const drmModeConnector& connector) {
  const char* const type = ::drmModeGetConnectorTypeName(connector.connector_type);
  return std::string(type != nullptr ? type : "Unknown") + "-" + std::to_string(connector.connector_type_id);
}

std::optional<drmModeModeInfo> choose_mode(const drmModeConnector& connector, std::uint32_t width, std::uint32_t height,
                                           std::uint32_t hz) {
  for (int i = 0; i < connector.count_modes; ++i) {
    const auto& mode = connector.modes[i];
    if (mode.hdisplay == width && mode.vdisplay == height && (hz == 0 || mode.vrefresh == hz)) return mode;
  }
  return std::nullopt;
}

/// @param taken  object number of a controller that is in use; 0: none
bool choose_crtc(const drmModeRes& resources, const drmModeConnector& connector, std::uint32_t taken,
                 FoundPanel& found) {
  for (int e = 0; e < connector.count_encoders; ++e) {
    const Encoder encoder(::drmModeGetEncoder(found.card.get(), connector.encoders[e]));
    if (!encoder) continue;
    for (int c = 0; c < resources.count_crtcs; ++c) {
      if ((encoder->possible_crtcs & (1U << static_cast<unsigned>(c))) == 0 || resources.crtcs[c] == taken) continue;
      found.crtc = resources.crtcs[c];
      found.crtc_index = static_cast<std::uint32_t>(c);
      return true;
    }
  }
  return false;
}

/// Searches one card.
/// @param others  gets the names of other connectors, for the message
/// @param found   filled in if the card has the connector
/// @returns whether it has
Expected<bool> search_card(const std::string& path, const DisplaySettings& settings, std::uint32_t width,
                           std::uint32_t height, const std::optional<CardInUse>& beside, std::string& others,
                           FoundPanel& found) {
  found.path = path;
  const bool in_use = beside && beside->path == path;
  found.card = File(in_use ? ::fcntl(beside->descriptor, F_DUPFD_CLOEXEC, 0)
                           : ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK));
  if (found.card.get() < 0) {
    if (errno == EACCES) return panel_failed("can't be reached", errno);
    return false;
  }
  const Resources resources(::drmModeGetResources(found.card.get()));
  if (!resources) return false;  // a card without displays
  for (int i = 0; i < resources->count_connectors; ++i) {
    const Connector connector(::drmModeGetConnector(found.card.get(), resources->connectors[i]));
    if (!connector) continue;
    const std::string name = connector_name(*connector);
    if (name != settings.connector) {
      others += (others.empty() ? "" : ", ") + name;
      continue;
    }
    if (connector->connection != DRM_MODE_CONNECTED || connector->count_modes == 0) {
      return fail(ErrorCode::kPanelFailed, "the panel: nothing is connected to %s of %s:\tcheck the cable",
                  name.c_str(), path.c_str());
    }
    const auto mode = choose_mode(*connector, width, height, settings.refresh_hz);
    if (!mode) {
      std::string modes;
      for (int m = 0; m < std::min(connector->count_modes, 8); ++m) {
        modes += (m == 0 ? "" : ", ") + mode_name(connector->modes[m]);
      }
      return fail(ErrorCode::kBadSetting, "the panel: %s has no mode of %ux%u pixels%s; it has %s", name.c_str(), width,
                  height, settings.refresh_hz == 0 ? "" : " with this refresh rate", modes.c_str());
    }
    found.connector = connector->connector_id;
    found.mode = *mode;
    if (!choose_crtc(*resources, *connector, in_use ? beside->crtc : 0, found))
      return panel_failed("has no controller for its connector", ENODEV);
    return true;
  }
  return false;
}

}  // namespace

tl::unexpected<Error> panel_failed(const char* what, int reason) {
  const char* next = "";
  if (reason == EACCES || reason == EPERM)
    next = ": another program has the display, or permission is missing (group video)";
  return fail(ErrorCode::kPanelFailed, "the panel %s: %s%s", what, std::strerror(reason), next);
}

std::string mode_name(const drmModeModeInfo& mode) {
  return std::to_string(mode.hdisplay) + "x" + std::to_string(mode.vdisplay) + " at " + std::to_string(mode.vrefresh) +
         " Hz";
}

Expected<FoundPanel> find_panel(const DisplaySettings& settings, std::uint32_t width, std::uint32_t height,
                                const std::optional<CardInUse>& beside) {
  std::vector<std::string> cards;
  if (!settings.card.empty()) {
    cards.push_back(settings.card);
  } else {
    // More than any board has; cards that don't exist are skipped.
    for (int i = 0; i < 8; ++i) cards.push_back(std::string("/dev/dri/card").append(std::to_string(i)));
  }
  std::string others;
  for (const auto& path : cards) {
    FoundPanel found;
    const auto here = search_card(path, settings, width, height, beside, others, found);
    PLUMBLINE_TRY(here);
    if (*here) return found;
  }
  return fail(ErrorCode::kBadSetting, "the panel: this board has no connector %s; it has %s",
              settings.connector.c_str(), others.empty() ? "none" : others.c_str());
}

std::string driver_of(int card) {
  drmVersion* const version = ::drmGetVersion(card);
  if (version == nullptr) return "unknown";
  std::string name(version->name, static_cast<std::size_t>(std::max(0, version->name_len)));
  ::drmFreeVersion(version);
  return name;
}

}  // namespace plumbline::inline hal::inline linux_board::kms
