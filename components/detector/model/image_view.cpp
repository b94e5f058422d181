// SPDX-License-Identifier: Apache-2.0
#include "detector/model/image_view.hpp"

#include <array>
#include <limits>

namespace nacelle::detector {
namespace {

struct Known {
  std::string_view encoding;
  Layout layout;
  int channels;
};
constexpr std::array<Known, 5> kKnown{{{"rgb8", Layout::Rgb8, 3},
                                       {"bgr8", Layout::Bgr8, 3},
                                       {"mono8", Layout::Mono8, 1},
                                       {"yuyv", Layout::Yuyv, 2},
                                       {"yuv422_yuy2", Layout::Yuyv, 2}}};  // yuyv's name before jazzy

}  // namespace

const char* to_text(ViewFault fault) {
  return fault == ViewFault::UnknownEncoding ? "its encoding is none of rgb8, bgr8, mono8 and yuyv"
                                             : "it has fewer bytes than its size and step say";
}

Result<ImageView, ViewFault> view_of(const sensor_msgs::msg::Image& image) {
  const Known* known = nullptr;
  for (const Known& candidate : kKnown) {
    if (image.encoding == candidate.encoding) known = &candidate;
  }
  if (known == nullptr) return err(ViewFault::UnknownEncoding);
  constexpr auto kMost =
      static_cast<std::uint32_t>(std::numeric_limits<std::int16_t>::max());  // OpenCV's own limit for coordinates
  const std::size_t line = std::size_t{image.width} * static_cast<std::size_t>(known->channels);
  if (image.width == 0 || image.height == 0 || image.width > kMost || image.height > kMost || image.step < line ||
      image.data.size() < std::size_t{image.step} * (image.height - 1) + line) {
    return err(ViewFault::TooShort);
  }
  // OpenCV has no read-only matrix; nothing in this component writes into the view.
  auto* const bytes = const_cast<std::uint8_t*>(image.data.data());
  return ImageView{cv::Mat(static_cast<int>(image.height), static_cast<int>(image.width), CV_8UC(known->channels),
                           bytes, image.step),
                   known->layout};
}

}  // namespace nacelle::detector
