#include "firmware/page/clients/access.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

namespace plumbline::firmware::inline page {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool equal(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

/// The name before the port; an IPv6 address without its brackets. Empty: there is none.
std::string_view name_of(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? "" : host.substr(1, end - 1);
  }
  return host.substr(0, host.find(':'));
}

bool is_address(std::string_view name, int family) {
  std::array<char, 64> text{};
  std::array<unsigned char, 16> address{};
  if (name.size() >= text.size()) return false;
  name.copy(text.data(), name.size());
  return ::inet_pton(family, text.data(), address.data()) == 1;
}

}  // namespace

bool is_known_host(std::string_view host, PageChoice page, std::string_view page_host) {
  const std::string_view name = name_of(host);
  if (name.empty()) return false;
  if (equal(name, "localhost") || name == "127.0.0.1" || (host.starts_with('[') && name == "::1")) return true;
  if (page != PageChoice::kNetwork) return false;
  constexpr std::string_view kLocalNames = ".local";
  const bool ends_in_local =
      name.size() > kLocalNames.size() && equal(name.substr(name.size() - kLocalNames.size()), kLocalNames);
  return is_address(name, host.starts_with('[') ? AF_INET6 : AF_INET) || name.find('.') == std::string_view::npos ||
         ends_in_local || (!page_host.empty() && equal(name, page_host));
}

bool is_same_origin(std::string_view host, std::string_view origin) {
  constexpr std::array<std::string_view, 2> kSchemes = {"http://", "https://"};
  return !host.empty() && std::any_of(kSchemes.begin(), kSchemes.end(), [&](std::string_view scheme) {
    return origin.starts_with(scheme) && equal(origin.substr(scheme.size()), host);
  });
}

}  // namespace plumbline::firmware::inline page
