// SPDX-License-Identifier: Apache-2.0
#include "camera/model/pattern_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "nacelle/base/expect.hpp"

namespace nacelle::camera {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr std::uint32_t kFloorTile_px = 32;  // the floor repeats after two tiles

struct Yuv {
  std::uint8_t y, u, v;
};

// Source: ITU-R BT.601, full range, the inverse of what yuv.cpp computes.
Yuv yuv_of(const std::uint8_t (&rgb)[3]) {
  const double r = rgb[0], g = rgb[1], b = rgb[2];
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)); };
  return {byte(0.299 * r + 0.587 * g + 0.114 * b), byte(128 - 0.168736 * r - 0.331264 * g + 0.5 * b),
          byte(128 + 0.5 * r - 0.418688 * g - 0.081312 * b)};
}

}  // namespace

bool PatternScene::can_draw(FourCc format) {
  return format == kRgb24 || format == kBgr24 || format == kYuyv || format == kUyvy || format == kGrey;
}

PatternScene::PatternScene(std::uint32_t width, std::uint32_t height, FourCc format)
    : width_(width), height_(height), bytes_per_pixel_(0), floor_row_(height - height / 12), format_(format) {
  NACELLE_EXPECT(can_draw(format), "the pattern is drawn as rgb8, bgr8, yuyv, uyvy or mono8");
  NACELLE_EXPECT(width >= 16 && width <= 4096 && height >= 16 && height <= 4096 && width % 2 == 0,
                 "the pattern's sides are 16 to 4096 pixels, the width even");
  bytes_per_pixel_ = find_pixel_format(format)->bytes_per_pixel;
  draw_background();
}

Pinhole PatternScene::pinhole() const {
  return {0.5 * width_ / std::tan(0.5 * kHorizontalView_rad), 0.5 * (width_ - 1.0), 0.5 * (height_ - 1.0)};
}

DiscPosition PatternScene::disc_position(std::uint64_t frame) {
  // Three periods without a common one below 35 s; at its nearest the disc is still wholly in a 4:3 picture.
  const auto phase = [frame](std::uint64_t period) {
    return kTwoPi * static_cast<double>(frame % period) / static_cast<double>(period);
  };
  return {0.35 * std::sin(phase(150)), 0.12 * std::sin(phase(210)), 1.5 + 0.5 * std::cos(phase(300))};
}

void PatternScene::put_pixel(std::uint8_t* row, std::uint32_t x, const std::uint8_t (&rgb)[3]) const {
  const Yuv yuv = yuv_of(rgb);
  std::uint8_t* const at = row + std::size_t{x} * bytes_per_pixel_;
  if (format_ == kRgb24 || format_ == kBgr24) {
    const bool swapped = format_ == kBgr24;
    at[0] = rgb[swapped ? 2 : 0];
    at[1] = rgb[1];
    at[2] = rgb[swapped ? 0 : 2];
  } else if (format_ == kGrey) {
    at[0] = yuv.y;
  } else {
    const unsigned luma = format_ == kYuyv ? 0 : 1;
    at[luma] = yuv.y;
    at[1 - luma] = x % 2 == 0 ? yuv.u : yuv.v;
  }
}

void PatternScene::draw_background() {
  const std::size_t line = bytes_per_line();
  wall_.resize(line * floor_row_);
  for (std::uint32_t y = 0; y < floor_row_; ++y) {
    for (std::uint32_t x = 0; x < width_; ++x) {
      // Grey with a seam every 80 pixels: something to focus on, and nothing that a colour detector could take for the
      // disc.
      const bool seam = x % 80 < 2 || y % 80 < 2;
      const auto grey = static_cast<std::uint8_t>(seam ? 60 : 110 + 60 * y / floor_row_);
      put_pixel(wall_.data() + line * y, x, {grey, grey, static_cast<std::uint8_t>(grey + 8)});
    }
  }
  floor_line_.resize(line + std::size_t{2} * kFloorTile_px * bytes_per_pixel_);
  for (std::uint32_t x = 0; x < width_ + 2 * kFloorTile_px; ++x) {
    const std::uint8_t grey = (x / kFloorTile_px) % 2 == 0 ? 40 : 200;
    put_pixel(floor_line_.data(), x, {grey, grey, grey});
  }
  disc_line_.resize(line);
  for (std::uint32_t x = 0; x < width_; ++x) put_pixel(disc_line_.data(), x, kDiscRgb);
}

void PatternScene::fill_run(std::uint8_t* row, std::uint32_t first, std::uint32_t last) const {
  if (format_ != kYuyv && format_ != kUyvy) {
    const std::size_t from = std::size_t{first} * bytes_per_pixel_;
    std::memcpy(row + from, disc_line_.data() + from, std::size_t{last - first + 1} * bytes_per_pixel_);
    return;
  }
  // Two pixels share their colour. A pair that is half disc gets the mean, as a camera's sensor would see it.
  const unsigned luma = format_ == kYuyv ? 0 : 1;
  for (std::uint32_t x = first; x <= last; ++x) row[2 * x + luma] = disc_line_[2 * x + luma];
  for (std::uint32_t pair = first / 2; pair <= last / 2; ++pair) {
    const bool whole = 2 * pair >= first && 2 * pair + 1 <= last;
    for (const std::uint32_t at : {4 * pair + 1 - luma, 4 * pair + 3 - luma}) {
      row[at] = whole ? disc_line_[at] : static_cast<std::uint8_t>((row[at] + disc_line_[at] + 1) / 2);
    }
  }
}

void PatternScene::draw_disc(std::uint64_t frame, std::uint8_t* out) const {
  const DiscPosition disc = disc_position(frame);
  const Pinhole lens = pinhole();
  const double u_px = lens.centre_u_px + lens.focal_px * disc.x_m / disc.z_m;
  const double v_px = lens.centre_v_px + lens.focal_px * disc.y_m / disc.z_m;
  const double radius_px = lens.focal_px * 0.5 * kDiscDiameter_m / disc.z_m;
  const double last_row = std::min<double>(height_ - 1.0, std::floor(v_px + radius_px));
  for (double y = std::max(0.0, std::ceil(v_px - radius_px)); y <= last_row; ++y) {
    const double half_px = std::sqrt(std::max(0.0, radius_px * radius_px - (y - v_px) * (y - v_px)));
    const double first = std::max(0.0, std::ceil(u_px - half_px));
    const double last = std::min<double>(width_ - 1.0, std::floor(u_px + half_px));
    if (first > last) continue;
    fill_run(out + static_cast<std::size_t>(y) * bytes_per_line(), static_cast<std::uint32_t>(first),
             static_cast<std::uint32_t>(last));
  }
}

void PatternScene::render(std::uint64_t frame, ByteSpan out) const {
  NACELLE_EXPECT(out.size() >= frame_bytes(), "the picture needs frame_bytes() bytes");
  std::memcpy(out.data(), wall_.data(), wall_.size());
  // Two pixels a frame: a step of one would swap U and V of yuyv.
  const std::size_t shift = (2 * frame) % (2 * kFloorTile_px) * bytes_per_pixel_;
  for (std::uint32_t y = floor_row_; y < height_; ++y) {
    std::memcpy(out.data() + std::size_t{y} * bytes_per_line(), floor_line_.data() + shift, bytes_per_line());
  }
  draw_disc(frame, out.data());
}

}  // namespace nacelle::camera
