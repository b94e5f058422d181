// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::camera {

/// The size of a packed picture in memory.
struct PictureShape {
  std::uint32_t width = 0, height = 0;
  std::uint32_t bytes_per_line = 0;  ///< At least width times the pixel's bytes; drivers may pad lines.
  friend bool operator==(const PictureShape&, const PictureShape&) = default;
};

// Packed layouts of two pixels in four bytes (the width is even):
//
//   byte    0    1    2    3
//   YUYV    Y0   U    Y1   V
//   UYVY    U    Y0   V    Y1
//
// Source: kernel, Documentation/userspace-api/media/v4l/pixfmt-packed-yuv.rst.
// Colours: ITU-R BT.601, full range: R = Y + 1.402 (V-128), G = Y - 0.344 (U-128) - 0.714 (V-128), B = Y + 1.772
// (U-128), in 16-bit fixed point; at most one step off the rounded value of the formula.

enum class YuvOrder : std::uint8_t { Yuyv, Uyvy };
enum class RgbOrder : std::uint8_t { Rgb, Bgr };

/// Converts to three bytes per pixel without padding.
///
/// Errors:    false, and nothing is written, if `in` or `out` is too small for the shape or the width is odd.
/// Allocates: nothing.
[[nodiscard]] bool yuv_to_rgb(ByteView in, const PictureShape& shape, YuvOrder order, RgbOrder to, ByteSpan out);

/// Keeps the brightness: one byte per pixel without padding. Errors as yuv_to_rgb().
[[nodiscard]] bool yuv_to_mono(ByteView in, const PictureShape& shape, YuvOrder order, ByteSpan out);

// NV12: a plane of Y, a byte per pixel; then one of U V U V, a pair for four pixels. Lines of both have bytes_per_line bytes; width
// and height are even.
// Source: kernel, Documentation/userspace-api/media/v4l/pixfmt-yuv-planar.rst.

/// As yuv_to_rgb(); `out` is the same as for YUYV with the same colour in both lines of a pair.
[[nodiscard]] bool nv12_to_rgb(ByteView in, const PictureShape& shape, RgbOrder to, ByteSpan out);
/// As yuv_to_mono().
[[nodiscard]] bool nv12_to_mono(ByteView in, const PictureShape& shape, ByteSpan out);

/// Swaps the first and third byte of each pixel: rgb8 to bgr8 or back, without padding. Errors: as yuv_to_rgb().
[[nodiscard]] bool swap_red_blue(ByteView in, const PictureShape& shape, ByteSpan out);

}  // namespace nacelle::camera
