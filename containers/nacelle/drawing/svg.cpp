// SPDX-License-Identifier: Apache-2.0
#include "drawing/svg.hpp"

#include <fmt/format.h>
#include <utf8cpp/utf8/unchecked.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace nacelle::drawing {
namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";

std::string pixels(double value) { return svg_number(value, 1); }

}  // namespace

std::string svg_number(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string svg_number_scientific(double value, int decimals) {
  std::string text = fmt::format("{:.{}e}", value, decimals);
  // "1.5e+09" is "1.5e9".
  const std::size_t e = text.find('e') + 1;
  const bool is_small = text[e] == '-';
  std::string exponent = text.substr(e + 1);
  exponent.erase(0, std::min(exponent.find_first_not_of('0'), exponent.size() - 1));
  return text.substr(0, e) + (is_small ? "-" : "") + exponent;
}

std::string svg_text(const std::string& text) {
  std::string valid, out;
  utf8::unchecked::replace_invalid(text.begin(), text.end(), std::back_inserter(valid));
  for (std::size_t i = 0; i < valid.size(); ++i) {
    const char c = valid[i];
    // U+FFFE and U+FFFF
    const bool is_no_character = valid.compare(i, 3, "\xEF\xBF\xBE") == 0 || valid.compare(i, 3, "\xEF\xBF\xBF") == 0;
    switch (c) {
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '&': out += "&amp;"; break;
      case '"': out += "&quot;"; break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 || is_no_character ? std::string{kReplacement} : std::string(1, c);
    }
    if (is_no_character) i += 2;
  }
  return out;
}

SvgColours svg_file_colours() {
  return {"#333333",
          "#e6e6e6",
          "#999999",
          "#ffffff",
          {"#1f5fbf", "#d95f02", "#2a8f5c", "#a0459b", "#b08800", "#c0304a", "#3a9fb5", "#666666"}};
}

SvgColours svg_page_colours() {
  SvgColours colours{"var(--ink)", "var(--grid)", "var(--frame)", "none", {}};
  for (std::size_t i = 0; i < svg_file_colours().lines.size(); ++i)
    colours.lines.push_back(fmt::format("var(--line{})", i));
  return colours;
}

SvgPage::SvgPage(double width, double height, const SvgColours& colours, SvgPlace place) {
  const std::string across = svg_number(width, 0), down = svg_number(height, 0);
  const std::string words =
      fmt::format("font-family=\"sans-serif\" font-size=\"14\" fill=\"{}\">\n", svg_text(colours.ink));
  if (place == SvgPlace::Page) {
    text_ = fmt::format("<svg viewBox=\"0 0 {} {}\" {}", across, down, words);
    return;
  }
  text_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "{2}<rect width=\"{0}\" height=\"{1}\" fill=\"{3}\"/>\n",
      across, down, words, svg_text(colours.paper));
}

void SvgPage::line(SvgPoint from, SvgPoint to, const std::string& colour, double thick) {
  text_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
                       pixels(from.x), pixels(from.y), pixels(to.x), pixels(to.y), colour, thick);
}

void SvgPage::polyline(const std::vector<SvgPoint>& points, const std::string& colour, double thick,
                       const std::string& title) {
  text_ += "<polyline points=\"";
  for (std::size_t i = 0; i < points.size(); ++i)
    text_ += (i == 0 ? "" : " ") + pixels(points[i].x) + "," + pixels(points[i].y);
  text_ += fmt::format(
      "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"><title>{}</title>"
      "</polyline>\n",
      colour, thick, svg_text(title));
}

void SvgPage::dot(SvgPoint at, double radius, const std::string& colour) {
  text_ +=
      fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>\n", pixels(at.x), pixels(at.y), radius, colour);
}

void SvgPage::bar(SvgPoint upper_left, SvgPoint lower_right, const std::string& colour, const std::string& title) {
  text_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"", pixels(upper_left.x),
                       pixels(upper_left.y), pixels(lower_right.x - upper_left.x), pixels(lower_right.y - upper_left.y),
                       colour);
  text_ += title.empty() ? "/>\n" : fmt::format("><title>{}</title></rect>\n", svg_text(title));
}

void SvgPage::frame(SvgPoint upper_left, SvgPoint lower_right, const std::string& colour) {
  text_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{}\"/>\n",
                       pixels(upper_left.x), pixels(upper_left.y), pixels(lower_right.x - upper_left.x),
                       pixels(lower_right.y - upper_left.y), colour);
}

void SvgPage::text(SvgPoint at, const std::string& words, SvgAnchor anchor) {
  const char* const name = anchor == SvgAnchor::Start ? "start" : anchor == SvgAnchor::Middle ? "middle" : "end";
  text_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n", pixels(at.x), pixels(at.y), name,
                       svg_text(words));
}

void SvgPage::text_upwards(SvgPoint at, const std::string& words) {
  text_ += fmt::format("<text transform=\"translate({} {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                       pixels(at.x), pixels(at.y), svg_text(words));
}

}  // namespace nacelle::drawing
