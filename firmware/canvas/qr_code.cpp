#include "firmware/canvas/qr_code.hpp"

#if PLUMBLINE_HAS_QRENCODE
#include <qrencode.h>
#endif

#include <algorithm>
#include <memory>

namespace plumbline::firmware::inline canvas {
namespace {

constexpr int kMargin = 4;  ///< white modules around the code, ISO/IEC 18004, 5.3.8

}  // namespace

#if PLUMBLINE_HAS_QRENCODE
bool QrCode::is_built() { return true; }

QrCode::QrCode(std::string_view text) {
  std::array<char, std::size_t{kMostText} + 1> terminated{};
  if (text.empty() || text.size() >= terminated.size()) return;
  std::ranges::copy(text, terminated.begin());
  // A screen is neither torn nor dirty: the least correction gives the largest modules.
  const std::unique_ptr<QRcode, decltype(&QRcode_free)> code(
      QRcode_encodeString8bit(terminated.data(), 0, QR_ECLEVEL_L), &QRcode_free);
  if (!code || code->width > kMostModules) return;
  modules_ = code->width;
  for (int y = 0; y < modules_; ++y) {
    for (int x = 0; x < modules_; ++x) {
      dark_[static_cast<std::size_t>(y * kMostModules + x)] = (code->data[y * modules_ + x] & 1U) != 0;
    }
  }
}
#else
bool QrCode::is_built() { return false; }

QrCode::QrCode(std::string_view /*text*/) {}
#endif

int QrCode::side_in(int room) const {
  if (modules_ == 0) return 0;
  const int all = modules_ + 2 * kMargin;
  return room / all * all;
}

void QrCode::draw(Canvas& to, int x, int y, int side) const {
  if (side == 0) return;
  const int module = side / (modules_ + 2 * kMargin);
  to.fill({x, y, side, side}, colour(255, 255, 255));
  for (int row = 0; row < modules_; ++row) {
    for (int column = 0; column < modules_; ++column) {
      if (!is_dark(column, row)) continue;
      to.fill({x + (column + kMargin) * module, y + (row + kMargin) * module, module, module}, colour(0, 0, 0));
    }
  }
}

}  // namespace plumbline::firmware::inline canvas
