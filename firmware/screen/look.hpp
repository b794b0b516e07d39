#pragma once
/// Sizes and colours of the screens. All sizes grow with the panel, so that a screen of 320 x 240 and one of 1024 x 600 hold the same.

#include "firmware/canvas/canvas.hpp"
#include "firmware/canvas/face.hpp"

namespace plumbline::firmware::inline screen {

namespace ink {
inline constexpr Colour kGround = colour(10, 14, 18);
inline constexpr Colour kBar = colour(30, 44, 58);      ///< title and buttons
inline constexpr Colour kChosen = colour(24, 92, 150);  ///< the row at hand
inline constexpr Colour kTrough = colour(52, 64, 76);   ///< what of a bar is not reached yet
inline constexpr Colour kText = colour(255, 255, 255);
inline constexpr Colour kPale = colour(176, 192, 206);  ///< less important; contrast above 9 : 1
inline constexpr Colour kDark = colour(0, 0, 0);        ///< text on bright colours
inline constexpr Colour kGood = colour(96, 220, 120);
inline constexpr Colour kAttention = colour(255, 196, 40);
inline constexpr Colour kFault = colour(255, 112, 96);
inline constexpr Colour kFaultBar = colour(188, 24, 24);  ///< below white text
}  // namespace ink

/// The smallest screen, pixels.
inline constexpr int kLeastColumns = 320, kLeastRows = 240;

/// The buttons' bar at the bottom of every screen, three of the same width: rows at 320 x 240.
inline constexpr int kButtonRows = 44;

/// The fonts of a screen, and its sizes. Takes all its memory when it is made.
struct Look {
  /// @param columns, rows  at least kLeastColumns x kLeastRows
  Look(int columns, int rows);

  /// A size that is given for 320 x 240.
  int px(int at_320) const { return at_320 * thirds / 3; }

  int thirds;  ///< of the size for 320 x 240: whole ones keep letters sharp
  Face plain;
  Face bold;
  Face title;
  Face large;
};

}  // namespace plumbline::firmware::inline screen
