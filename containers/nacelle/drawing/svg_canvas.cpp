// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nacelle/drawing/canvas.hpp"

namespace nacelle::drawing {
namespace {

const char* svg_colour(Ink ink) {
  switch (ink) {
    case Ink::Black: return "black";
    case Ink::Grey: return "#666";
    case Ink::Red: return "crimson";
  }
  return "black";
}

const char* word_of(Anchor anchor) {
  switch (anchor) {
    case Anchor::Start: return "start";
    case Anchor::Middle: return "middle";
    case Anchor::End: return "end";
  }
  return "start";
}

class SvgCanvas final : public Canvas {
 public:
  SvgCanvas(double width, double height)
      : out_(fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
                         "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\">\n"
                         "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
                         width, height)) {}

  void box(Point corner, double width, double height) override {
    out_ +=
        fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"4\" fill=\"#fdf8e8\" stroke=\"black\"/>\n",
                    corner.x, corner.y, width, height);
  }
  void curve(Point from, Point to, Ink ink) override {
    const double bend = std::max(20.0, std::abs(to.x - from.x) / 2);
    out_ += fmt::format("<path d=\"M{},{} C{},{} {},{} {},{}\" fill=\"none\" stroke=\"{}\"/>\n", from.x, from.y,
                        from.x + bend, from.y, to.x - bend, to.y, to.x, to.y, svg_colour(ink));
  }
  void text(Point at, Anchor anchor, const std::vector<Span>& spans) override {
    out_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\">", at.x, at.y, word_of(anchor));
    for (const Span& span : spans) {
      out_ += fmt::format("<tspan font-size=\"{}\"{} fill=\"{}\">{}</tspan>", span.size,
                          span.bold ? " font-weight=\"bold\"" : "", svg_colour(span.ink), escaped(span.text));
    }
    out_ += "</text>\n";
  }
  Result<std::string, Problem> finish() override { return std::move(out_) + "</svg>\n"; }

 private:
  std::string out_;
};

}  // namespace

std::unique_ptr<Canvas> make_svg_canvas(double width, double height) {
  return std::make_unique<SvgCanvas>(width, height);
}

double width_of(const std::vector<Span>& spans) {
  constexpr double kMeanLetter = 0.58;  // of the size; sans-serif, a little generous
  double width = 0;
  for (const Span& span : spans) width += kMeanLetter * span.size * static_cast<double>(span.text.size());
  return width;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '&': out += "&amp;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

}  // namespace nacelle::drawing
