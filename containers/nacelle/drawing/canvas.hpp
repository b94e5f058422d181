// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::drawing {

/// In pixels of an SVG, which are points of a PDF; y grows downwards.
struct Point {
  double x = 0, y = 0;
};
enum class Ink { Black, Grey, Red };
enum class Anchor { Start, Middle, End };
struct Span {
  std::string text;
  double size = 12;
  bool bold = false;
  Ink ink = Ink::Black;
};

/// A drawing of one page. Threads: one.
class Canvas {
 public:
  virtual ~Canvas() = default;
  /// Filled lightly, with a border.
  virtual void box(Point corner, double width, double height) = 0;
  /// Leaves `from` and reaches `to` horizontally.
  virtual void curve(Point from, Point to, Ink ink) = 0;
  /// One line, its spans side by side; `at` is on the base line.
  virtual void text(Point at, Anchor anchor, const std::vector<Span>& spans) = 0;
  /// The whole file. Ends the drawing. Errors: why it could not be made.
  [[nodiscard]] virtual Result<std::string, Problem> finish() = 0;
};

[[nodiscard]] std::unique_ptr<Canvas> make_svg_canvas(double width, double height);
/// The page is as large as the drawing; letters that Latin-1 lacks come out as question marks.
[[nodiscard]] std::unique_ptr<Canvas> make_pdf_canvas(double width, double height);

/// About how wide a line will be: for boxes around it.
[[nodiscard]] double width_of(const std::vector<Span>& spans);
/// Text for XML.
[[nodiscard]] std::string escaped(const std::string& text);

}  // namespace nacelle::drawing
