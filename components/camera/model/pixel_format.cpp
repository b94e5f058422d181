// SPDX-License-Identifier: Apache-2.0
#include "camera/model/pixel_format.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace nacelle::camera {
namespace {

// Source: ros2/common_interfaces jazzy, sensor_msgs/image_encodings.hpp; linux/videodev2.h.
// In the order of preference if a device does not offer the requested format.
constexpr std::array<PixelFormat, 12> kFormats{{
    {kYuyv, "yuyv", 2},
    {kUyvy, "uyvy", 2},
    {kRgb24, "rgb8", 3},
    {kBgr24, "bgr8", 3},
    {kMjpeg, "", 0},
    {kJpeg, "", 0},
    {kNv12, "", 1, 3},
    {kGrey, "mono8", 1},
    {fourcc("BA81"), "bayer_bggr8", 1},
    {fourcc("GBRG"), "bayer_gbrg8", 1},
    {fourcc("GRBG"), "bayer_grbg8", 1},
    {fourcc("RGGB"), "bayer_rggb8", 1},
}};

}  // namespace

const PixelFormat* find_pixel_format(FourCc code) {
  const auto* const found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& f) { return f.code == code; });
  return found == kFormats.end() ? nullptr : found;
}

const PixelFormat* find_pixel_format(std::string_view encoding) {
  if (encoding.empty()) return nullptr;
  // The names that these two had before jazzy.
  if (encoding == "yuv422_yuy2") encoding = "yuyv";
  if (encoding == "yuv422") encoding = "uyvy";
  const auto* const found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& f) { return f.encoding == encoding; });
  return found == kFormats.end() ? nullptr : found;
}

const PixelFormat* readable_formats_begin() { return kFormats.begin(); }
const PixelFormat* readable_formats_end() { return kFormats.end(); }

std::optional<FourCc> parse_fourcc(std::string_view text) {
  if (text.size() != 4) return std::nullopt;
  FourCc code = 0;
  for (unsigned i = 0; i < 4; ++i) {
    auto c = static_cast<unsigned char>(text[i]);
    if (c < ' ' || c > '~') return std::nullopt;
    if (c >= 'a' && c <= 'z') c = static_cast<unsigned char>(c - 'a' + 'A');
    code |= static_cast<FourCc>(c) << (8 * i);
  }
  return code;
}

std::string to_text(FourCc code) {
  std::string text;
  for (unsigned i = 0; i < 4; ++i) {
    const auto c = static_cast<char>((code >> (8 * i)) & 0xFF);
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text;
}

}  // namespace nacelle::camera
