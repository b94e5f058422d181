// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

#include "image_proc/model/picture.hpp"

namespace nacelle::image_proc {

/// An image whose byte of channel c at (x, y) is value(x, y, c). Rows have `padding` bytes of 0xEE behind them.
inline sensor_msgs::msg::Image image_of(std::uint32_t width, std::uint32_t height, const char* encoding,
                                        std::uint32_t channels, const std::function<double(double, double, int)>& value,
                                        std::uint32_t padding = 0) {
  sensor_msgs::msg::Image image;
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.step = width * channels + padding;
  image.data.assign(std::size_t{image.step} * height, std::uint8_t{0xEE});
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      for (std::uint32_t c = 0; c < channels; ++c) {
        image.data[std::size_t{y} * image.step + x * channels + c] =
            static_cast<std::uint8_t>(value(x, y, static_cast<int>(c)) + 0.5);
      }
    }
  }
  return image;
}

inline int byte_at(const sensor_msgs::msg::Image& image, std::uint32_t x, std::uint32_t y, std::uint32_t channel = 0,
                   std::uint32_t channels = 1) {
  return image.data[std::size_t{y} * image.step + x * channels + channel];
}

}  // namespace nacelle::image_proc
