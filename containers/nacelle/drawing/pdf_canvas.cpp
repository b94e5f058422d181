// SPDX-License-Identifier: Apache-2.0
// By libharu, which is small and in Debian; its errors come through a callback.
#include <fmt/format.h>
#include <hpdf.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "nacelle/drawing/canvas.hpp"

namespace nacelle::drawing {
namespace {

// Of the PDF format, since a page may not be larger; a larger drawing is scaled down.
constexpr double kLongest = 14400;

std::array<float, 3> colour_of(Ink ink) {
  switch (ink) {
    case Ink::Black: return {0, 0, 0};
    case Ink::Grey: return {0.4F, 0.4F, 0.4F};
    case Ink::Red: return {0.86F, 0.08F, 0.24F};
  }
  return {0, 0, 0};
}

/// UTF-8 to the fonts' encoding, whose lower part is ASCII.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) out += byte < 0x20 ? ' ' : c;
    if (byte >= 0xC0) out += '?';  // the first byte of a longer one
  }
  return out;
}

class PdfCanvas final : public Canvas {
 public:
  PdfCanvas(double width, double height)
      : scale_(std::min(1.0, kLongest / std::max(width, height))),
        height_(height),
        pdf_(HPDF_New(&PdfCanvas::note_error, this)) {
    if (pdf_ == nullptr) return;
    page_ = HPDF_AddPage(pdf_);
    if (page_ == nullptr) return;
    HPDF_Page_SetWidth(page_, number(std::max(width * scale_, 3.0)));
    HPDF_Page_SetHeight(page_, number(std::max(height * scale_, 3.0)));
    HPDF_Page_Concat(page_, number(scale_), 0, 0, number(scale_), 0, 0);
    regular_ = HPDF_GetFont(pdf_, "Helvetica", "WinAnsiEncoding");
    bold_ = HPDF_GetFont(pdf_, "Helvetica-Bold", "WinAnsiEncoding");
  }
  PdfCanvas(const PdfCanvas&) = delete;
  PdfCanvas& operator=(const PdfCanvas&) = delete;
  ~PdfCanvas() override {
    if (pdf_ != nullptr) HPDF_Free(pdf_);
  }

  void box(Point corner, double width, double height) override {
    if (!works()) return;
    HPDF_Page_SetRGBFill(page_, 0.99F, 0.97F, 0.91F);
    stroke_in(Ink::Black);
    HPDF_Page_Rectangle(page_, number(corner.x), up(corner.y + height), number(width), number(height));
    HPDF_Page_FillStroke(page_);
  }
  void curve(Point from, Point to, Ink ink) override {
    if (!works()) return;
    const double bend = std::max(20.0, std::abs(to.x - from.x) / 2);
    stroke_in(ink);
    HPDF_Page_MoveTo(page_, number(from.x), up(from.y));
    HPDF_Page_CurveTo(page_, number(from.x + bend), up(from.y), number(to.x - bend), up(to.y), number(to.x), up(to.y));
    HPDF_Page_Stroke(page_);
  }
  void text(Point at, Anchor anchor, const std::vector<Span>& spans) override {
    if (!works()) return;
    double width = 0;
    for (const Span& span : spans) {
      choose_font(span);
      width += static_cast<double>(HPDF_Page_TextWidth(page_, plain(span.text).c_str()));
    }
    double x = at.x - (anchor == Anchor::End ? width : anchor == Anchor::Middle ? width / 2 : 0);
    for (const Span& span : spans) {
      choose_font(span);
      const auto [r, g, b] = colour_of(span.ink);
      HPDF_Page_SetRGBFill(page_, r, g, b);
      HPDF_Page_BeginText(page_);
      HPDF_Page_TextOut(page_, number(x), up(at.y), plain(span.text).c_str());
      HPDF_Page_EndText(page_);
      x += static_cast<double>(HPDF_Page_TextWidth(page_, plain(span.text).c_str()));
    }
  }
  Result<std::string, Problem> finish() override {
    if (works()) HPDF_SaveToStream(pdf_);
    if (!works()) return err(Problem{"the PDF", fmt::format("cannot be made: libharu's error 0x{:x}", error_), ""});
    std::string file(HPDF_GetStreamSize(pdf_), '\0');
    auto size = static_cast<HPDF_UINT32>(file.size());
    HPDF_ResetStream(pdf_);
    HPDF_ReadFromStream(pdf_, reinterpret_cast<HPDF_BYTE*>(file.data()), &size);
    file.resize(size);
    return file;
  }

 private:
  static void note_error(HPDF_STATUS error, HPDF_STATUS, void* self) {
    auto& canvas = *static_cast<PdfCanvas*>(self);
    if (canvas.error_ == 0) canvas.error_ = error;
  }
  static float number(double value) { return static_cast<float>(value); }
  [[nodiscard]] float up(double y) const { return number(height_ - y); }  // a page's y grows upwards
  [[nodiscard]] bool works() const { return page_ != nullptr && error_ == 0; }
  void stroke_in(Ink ink) {
    const auto [r, g, b] = colour_of(ink);
    HPDF_Page_SetRGBStroke(page_, r, g, b);
  }
  void choose_font(const Span& span) {
    HPDF_Page_SetFontAndSize(page_, span.bold ? bold_ : regular_, number(span.size));
  }

  HPDF_STATUS error_ = 0;  // the first
  double scale_, height_;
  HPDF_Doc pdf_;
  HPDF_Page page_ = nullptr;
  HPDF_Font regular_ = nullptr, bold_ = nullptr;
};

}  // namespace

std::unique_ptr<Canvas> make_pdf_canvas(double width, double height) {
  return std::make_unique<PdfCanvas>(width, height);
}

}  // namespace nacelle::drawing
