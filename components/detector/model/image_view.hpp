// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::detector {

/// How the pixels of an image are laid out.
enum class Layout : std::uint8_t { Rgb8, Bgr8, Mono8, Yuyv };

/// Why an image cannot be looked at.
enum class ViewFault : std::uint8_t {
  UnknownEncoding,  ///< Not rgb8, bgr8, mono8 or yuyv.
  TooShort          ///< Fewer bytes than height, width and step promise, or no pixel at all.
};
[[nodiscard]] const char* to_text(ViewFault fault);

/// An image as OpenCV sees it: a look at the message's own bytes.
struct ImageView {
  cv::Mat pixels;  ///< CV_8UC3, CV_8UC1, or CV_8UC2 for yuyv. Read only: other readers share the bytes.
  Layout layout;
};

/// Looks at the image without copying a byte; valid as long as the message.
/// Errors:    ViewFault; the message may come from anywhere.
/// Allocates: nothing.
[[nodiscard]] Result<ImageView, ViewFault> view_of(const sensor_msgs::msg::Image& image);

}  // namespace nacelle::detector
