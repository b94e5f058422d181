// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace nacelle::camera {

/// V4L2's name of a pixel layout: four characters, the first in the lowest byte.
using FourCc = std::uint32_t;

[[nodiscard]] constexpr FourCc fourcc(const char (&text)[5]) {
  FourCc code = 0;
  for (unsigned i = 0; i < 4; ++i) code |= static_cast<FourCc>(static_cast<unsigned char>(text[i])) << (8 * i);
  return code;
}

inline constexpr FourCc kYuyv = fourcc("YUYV"), kUyvy = fourcc("UYVY"), kMjpeg = fourcc("MJPG"), kJpeg = fourcc("JPEG"),
                        kGrey = fourcc("GREY"), kRgb24 = fourcc("RGB3"), kBgr24 = fourcc("BGR3"),
                        kNv12 = fourcc("NV12");
static_assert(kYuyv == 0x56595559 && kMjpeg == 0x47504A4D, "as in linux/videodev2.h");

[[nodiscard]] constexpr bool is_jpeg(FourCc code) { return code == kMjpeg || code == kJpeg; }

/// A layout that this component can read.
struct PixelFormat {
  FourCc code;
  std::string_view
      encoding;  ///< ROS 2's word of sensor_msgs/image_encodings.hpp; empty if it has none (NV12, compressed layouts).
  std::uint32_t bytes_per_pixel;  ///< Of a line; 0 for compressed layouts, whose frames vary in size.
  std::uint32_t lines_for_two =
      2;  ///< Lines in memory for two of the picture: 3 with a plane of colours behind the picture.
};

/// The layout of that name; null if the component cannot read it.
[[nodiscard]] const PixelFormat* find_pixel_format(FourCc code);
/// The layout that has that ROS encoding; null if there is none.
[[nodiscard]] const PixelFormat* find_pixel_format(std::string_view encoding);
/// The layouts that the component can read, the cheapest to handle first.
[[nodiscard]] const PixelFormat* readable_formats_begin();
[[nodiscard]] const PixelFormat* readable_formats_end();

/// "YUYV" or "yuyv", four printable characters; nothing otherwise.
[[nodiscard]] std::optional<FourCc> parse_fourcc(std::string_view text);
/// "YUYV"; characters that cannot be printed are shown as '?'.
[[nodiscard]] std::string to_text(FourCc code);

}  // namespace nacelle::camera
