// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "image_proc/model/sampling_map.hpp"
#include "sensor_msgs/msg/camera_info.hpp"

namespace nacelle::image_proc {

/// Makes pictures larger or smaller.
///
/// Source:    as OpenCV's resize(): the outer edges of both pictures meet, not the centres of their outermost pixels.
/// Threads:   one at a time.
/// Allocates: nearest and linear: at the first picture of a size. The others: scratch memory of OpenCV in each picture.
class Resizer {
 public:
  explicit Resizer(Interpolation interpolation) : interpolation_(interpolation) {}

  /// Makes the picture in the given size: width * height * channels bytes from `out` on.
  /// Preconditions: sides from 1 to kMostSide, at most kMostPixels.
  void resize(const Picture& picture, SamplingMap::Size made, std::uint8_t* out);

 private:
  [[nodiscard]] SamplingMap make_map(SamplingMap::Size source, SamplingMap::Size made) const;

  const Interpolation interpolation_;
  std::optional<SamplingMap> map_;
};

/// Scales size, K, P and region of interest from the picture's size to the one that is made of it.
///
/// Units: pixels. Source: ROS 2's image_proc: x of the focal length, the centre and P's fourth column times the ratio of
///        the widths, y that of the heights.
void scale(sensor_msgs::msg::CameraInfo& info, SamplingMap::Size picture, SamplingMap::Size made);

}  // namespace nacelle::image_proc
