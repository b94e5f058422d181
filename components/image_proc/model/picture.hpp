// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::image_proc {

/// Greatest width and height of a picture that is read or made, in pixels.
inline constexpr std::uint32_t kMostSide = 16384;
/// Most pixels of a picture that is read or made: 8192 x 4096.
inline constexpr std::size_t kMostPixels = std::size_t{1} << 25U;

/// An encoding of sensor_msgs/Image that has 8 bits a channel.
struct Encoding {
  std::string_view name;
  int channels;
};
/// What can be rectified, resized and compressed.
[[nodiscard]] std::span<const Encoding> plain_encodings();
/// What can be debayered.
[[nodiscard]] std::span<const Encoding> mosaic_encodings();

/// Why an image cannot be read.
enum class PictureFault : std::uint8_t {
  UnknownEncoding,  ///< None of the encodings that the component takes.
  BadSize,          ///< A side is below the least or above kMostSide, or there are more than kMostPixels pixels.
  StepTooShort,     ///< A row has fewer bytes than its pixels.
  DataTooShort      ///< Fewer bytes than height, width and step promise.
};

/// The pixels of an image: a look at the message's own bytes.
struct Picture {
  const std::uint8_t* pixels;
  std::uint32_t width, height;
  std::size_t step;  ///< Bytes from one row to the next, at least width * channels.
  Encoding encoding;
};

/// Looks at the image without copying a byte; valid as long as the message.
/// Errors:    PictureFault; the message may come from anywhere.
/// Allocates: nothing.
[[nodiscard]] Result<Picture, PictureFault> picture_of(const sensor_msgs::msg::Image& image,
                                                       std::span<const Encoding> known, std::uint32_t least_side = 1);

/// Returns what is wrong with the image, with its values and what would be right.
[[nodiscard]] std::string explain(PictureFault fault, const sensor_msgs::msg::Image& image,
                                  std::span<const Encoding> known, std::uint32_t least_side = 1);

/// Sets every field but the header for a picture without padding; the pixels' values are unspecified afterwards.
/// Allocates: only if the message has too little capacity.
void set_shape(sensor_msgs::msg::Image& image, std::uint32_t width, std::uint32_t height, const Encoding& encoding);

}  // namespace nacelle::image_proc
