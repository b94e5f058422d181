// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/resizer.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>

namespace nacelle::image_proc {
namespace {

int flag_of(Interpolation interpolation) {
  switch (interpolation) {
    case Interpolation::Cubic: return cv::INTER_CUBIC;
    case Interpolation::Area: return cv::INTER_AREA;
    case Interpolation::Lanczos4: return cv::INTER_LANCZOS4;
    default: return cv::INTER_LINEAR;
  }
}

// Of a pixel that is made, in the source.
double coordinate(std::uint32_t made, double ratio, std::uint32_t count, Interpolation interpolation) {
  const double last = count - 1;
  if (interpolation == Interpolation::Nearest) return std::min(std::floor(made * ratio), last);
  return std::clamp((made + 0.5) * ratio - 0.5, 0.0, last);
}

}  // namespace

SamplingMap Resizer::make_map(SamplingMap::Size source, SamplingMap::Size made) const {
  SamplingMap map{source, made};
  const double ratio_x = static_cast<double>(source.width) / made.width;
  const double ratio_y = static_cast<double>(source.height) / made.height;
  for (std::uint32_t v = 0; v < made.height; ++v) {
    const double y = coordinate(v, ratio_y, source.height, interpolation_);
    for (std::uint32_t u = 0; u < made.width; ++u)
      map.set(u, v, {coordinate(u, ratio_x, source.width, interpolation_), y}, interpolation_);
  }
  return map;
}

void Resizer::resize(const Picture& picture, SamplingMap::Size made, std::uint8_t* out) {
  if (interpolation_ == Interpolation::Nearest || interpolation_ == Interpolation::Linear) {
    const SamplingMap::Size source{picture.width, picture.height};
    if (!map_ || map_->source() != source || map_->made() != made) map_ = make_map(source, made);
    map_->apply(picture, out);
    return;
  }
  const int type = CV_8UC(picture.encoding.channels);
  // OpenCV has no read-only matrix; it does not write into its source.
  const cv::Mat from(static_cast<int>(picture.height), static_cast<int>(picture.width), type,
                     const_cast<std::uint8_t*>(picture.pixels), picture.step);
  cv::Mat to(static_cast<int>(made.height), static_cast<int>(made.width), type, out);
  cv::resize(from, to, to.size(), 0, 0, flag_of(interpolation_));
}

void scale(sensor_msgs::msg::CameraInfo& info, SamplingMap::Size picture, SamplingMap::Size made) {
  const double x = static_cast<double>(made.width) / picture.width;
  const double y = static_cast<double>(made.height) / picture.height;
  for (const std::size_t i : {0U, 1U, 2U}) {
    info.k[i] *= x;
    info.k[i + 3] *= y;
  }
  for (const std::size_t i : {0U, 1U, 2U, 3U}) {
    info.p[i] *= x;
    info.p[i + 4] *= y;
  }
  // From outside: a region may have any numbers, which must stay within theirs.
  const auto scaled = [](std::uint32_t pixels, double ratio) {
    return static_cast<std::uint32_t>(std::min(std::round(pixels * ratio), 4294967295.0));
  };
  info.roi.x_offset = scaled(info.roi.x_offset, x);
  info.roi.width = scaled(info.roi.width, x);
  info.roi.y_offset = scaled(info.roi.y_offset, y);
  info.roi.height = scaled(info.roi.height, y);
  info.width = made.width;
  info.height = made.height;
}

}  // namespace nacelle::image_proc
