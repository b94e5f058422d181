// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "image_proc/model/jpeg_encoder.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/compressed_image.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::look {

/// Makes small JPEG pictures for people: at most 640 pixels wide, the mean of as many pixels as fit. YUYV, UYVY and Bayer patterns are
/// shown, too, with less care than image_proc's.
///
/// Threads: one at a time. Allocates: the answer; scratch memory at the first picture of a size.
class PictureMaker {
 public:
  /// Returns the bytes of a sensor_msgs/msg/CompressedImage. Errors: why the picture cannot be shown.
  [[nodiscard]] Result<Bytes, std::string> make(const sensor_msgs::msg::Image& image);

 private:
  image_proc::JpegEncoder encoder_;
  sensor_msgs::msg::CompressedImage made_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace nacelle::look
