// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "camera/model/pixel_format.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::camera {

/// Where the disc's centre is. Units: m. Frame: the camera's optical frame (x right, y down, z forward).
struct DiscPosition {
  double x_m, y_m, z_m;
};

/// An ideal pinhole camera. Units: px; the centre of the first pixel is (0, 0).
struct Pinhole {
  double focal_px, centre_u_px, centre_v_px;
};

/// The scene that the camera shows when there is no device: a wall, a floor that moves, and an orange disc on a known
/// path.
///
/// The picture is a function of the frame number alone. The disc faces the camera, so that it appears as a circle whose
/// size depends on its distance. A detector's result can be compared with disc_position().
/// Threads:   const members from any thread.
/// Allocates: the background once, in the constructor; render() nothing.
class PatternScene {
 public:
  static constexpr double kDiscDiameter_m = 0.20;
  static constexpr double kFramesPerSecond =
      30.0;  ///< Of the path; a camera at another rate moves it faster or slower.
  static constexpr double kHorizontalView_rad = 1.0471975511965976;  ///< 60 degrees.
  static constexpr std::uint8_t kDiscRgb[3] = {255, 120, 0};

  /// `format` is kRgb24, kBgr24, kYuyv, kUyvy or kGrey; sides are 16 to 4096 pixels and the width is even.
  PatternScene(std::uint32_t width, std::uint32_t height, FourCc format);

  [[nodiscard]] static bool can_draw(FourCc format);
  [[nodiscard]] std::uint32_t bytes_per_line() const { return width_ * bytes_per_pixel_; }
  [[nodiscard]] std::size_t frame_bytes() const { return std::size_t{bytes_per_line()} * height_; }
  [[nodiscard]] Pinhole pinhole() const;
  [[nodiscard]] static DiscPosition disc_position(std::uint64_t frame);

  /// Draws the frame. Precondition: `out` holds frame_bytes().
  void render(std::uint64_t frame, ByteSpan out) const;

 private:
  void put_pixel(std::uint8_t* row, std::uint32_t x, const std::uint8_t (&rgb)[3]) const;
  void draw_background();
  void draw_disc(std::uint64_t frame, std::uint8_t* out) const;
  void fill_run(std::uint8_t* row, std::uint32_t first, std::uint32_t last) const;

  std::uint32_t width_, height_, bytes_per_pixel_, floor_row_;
  FourCc format_;
  std::vector<std::uint8_t> wall_;  ///< Rows above the floor.
  std::vector<std::uint8_t>
      floor_line_;  ///< One row of the floor and one more repeat, so that a shifted row is one copy.
  std::vector<std::uint8_t> disc_line_;  ///< A row full of the disc's colour.
};

}  // namespace nacelle::camera
