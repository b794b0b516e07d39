#pragma once
/// A text as a square code that phones read (ISO/IEC 18004).

#include <array>
#include <string_view>

#include "firmware/canvas/canvas.hpp"

namespace plumbline::firmware::inline canvas {

class QrCode {
 public:
  static constexpr int kMostModules = 37;  ///< version 5
  static constexpr int kMostText = 106;    ///< bytes that this version has room for, with the least correction

  /// Whether codes can be made: this was built with libqrencode.
  static bool is_built();

  /// Nothing is drawn of it.
  QrCode() = default;
  /// Takes some kilobytes from the heap and gives them back. Empty for an empty text, and for one of more than kMostText bytes.
  explicit QrCode(std::string_view text);

  /// Modules along a side; 0: it is empty.
  int modules() const { return modules_; }
  bool is_dark(int x, int y) const { return dark_[static_cast<std::size_t>(y * kMostModules + x)]; }

  /// The side of the code with its margin, if all modules are as large as a room allows; 0: it is empty or does not fit.
  int side_in(int room) const;
  /// Dark on white, with its margin.
  /// @param side  of side_in()
  void draw(Canvas& to, int x, int y, int side) const;

 private:
  int modules_ = 0;
  std::array<bool, std::size_t{kMostModules} * kMostModules> dark_{};  ///< row after row
};

}  // namespace plumbline::firmware::inline canvas
