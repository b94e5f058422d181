// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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
/// Returns a text for the content and the attributes of XML and HTML. What XML cannot have (control characters, bytes that are no UTF-8)
/// becomes U+FFFD. Pure.
[[nodiscard]] std::string svg_text(const std::string& text);

/// The colours of a picture.
struct SvgColours {
  std::string ink, grid, frame, paper;  ///< As "#333333". `ink`: of texts.
  std::vector<std::string> lines;       ///< One at least.

  /// Returns the colour of a line, from the first again after the last.
  [[nodiscard]] const std::string& of_line(std::size_t i) const { return lines[i % lines.size()]; }
};
/// Returns the colours of a picture that is a file: dark on white.
[[nodiscard]] SvgColours svg_file_colours();
/// Returns the colours as variables of the page's CSS: --ink, --grid, --frame, --line0 to --line7.
[[nodiscard]] SvgColours svg_page_colours();

/// Where a picture stands.
enum class SvgPlace : std::uint8_t {
  File,  ///< A document of its own, on paper.
  Page   ///< Within a page of HTML, as wide as the page makes it, without paper.
};

/// Writes an SVG picture of lines and texts. What comes later covers what came before.
class SvgPage {
 public:
  SvgPage(double width, double height, const SvgColours& colours, SvgPlace place);

  void line(SvgPoint from, SvgPoint to, const std::string& colour, double thick);
  /// `title`: what a viewer shows beside the pointer.
  void polyline(const std::vector<SvgPoint>& points, const std::string& colour, double thick, const std::string& title);
  void dot(SvgPoint at, double radius, const std::string& colour);
  /// A filled rectangle. `title`: what a viewer shows beside the pointer; empty: nothing.
  void bar(SvgPoint upper_left, SvgPoint lower_right, const std::string& colour, const std::string& title);
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
