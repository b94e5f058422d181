// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace nacelle::drawing {

/// A place on a page, in pixels from its upper left corner.
struct SvgPoint {
  double x = 0.0, y = 0.0;
};
/// Which part of a text stands at its place.
enum class SvgAnchor : std::uint8_t { Start, Middle, End };

/// Returns a number with so many decimals; never "-0". Pure.
[[nodiscard]] std::string svg_number(double value, int decimals);
/// Returns "1.5e9" with so many decimals. Pure.
[[nodiscard]] std::string svg_number_scientific(double value, int decimals);
/// Returns a text for the content and the attributes of XML. Control characters, which XML cannot have, become U+FFFD. Pure.
[[nodiscard]] std::string svg_text(const std::string& text);

/// Writes an SVG document of lines and texts on white paper. What comes later covers what came before.
class SvgPage {
 public:
  /// `ink`: the colour of texts, as "#333333".
  SvgPage(double width, double height, const std::string& ink);

  void line(SvgPoint from, SvgPoint to, const std::string& colour, double thick);
  /// `title`: what a viewer shows beside the pointer.
  void polyline(const std::vector<SvgPoint>& points, const std::string& colour, double thick, const std::string& title);
  void dot(SvgPoint at, double radius, const std::string& colour);
  /// A rectangle that is not filled.
  void frame(SvgPoint upper_left, SvgPoint lower_right, const std::string& colour);
  void text(SvgPoint at, const std::string& words, SvgAnchor anchor);
  /// A text that is read from below, with its middle here.
  void text_upwards(SvgPoint at, const std::string& words);

  /// Returns the document.
  [[nodiscard]] std::string text() const { return text_ + "</svg>\n"; }

 private:
  std::string text_;
};

}  // namespace nacelle::drawing
