// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace nacelle::image_proc {
namespace {

constexpr std::array<Encoding, 5> kPlain{{{"mono8", 1}, {"rgb8", 3}, {"bgr8", 3}, {"rgba8", 4}, {"bgra8", 4}}};
constexpr std::array<Encoding, 4> kMosaics{
    {{"bayer_rggb8", 1}, {"bayer_bggr8", 1}, {"bayer_gbrg8", 1}, {"bayer_grbg8", 1}}};
constexpr std::size_t kMostNameShown = 32;  // an encoding comes from outside

}  // namespace

std::span<const Encoding> plain_encodings() { return kPlain; }
std::span<const Encoding> mosaic_encodings() { return kMosaics; }

Result<Picture, PictureFault> picture_of(const sensor_msgs::msg::Image& image, std::span<const Encoding> known,
                                         std::uint32_t least_side) {
  const auto found =
      std::find_if(known.begin(), known.end(), [&](const Encoding& one) { return one.name == image.encoding; });
  if (found == known.end()) return err(PictureFault::UnknownEncoding);
  const auto [shorter, longer] = std::minmax(image.width, image.height);
  if (shorter < std::max(least_side, 1U) || longer > kMostSide ||
      std::size_t{image.width} * image.height > kMostPixels) {
    return err(PictureFault::BadSize);
  }
  const std::size_t line = std::size_t{image.width} * static_cast<std::size_t>(found->channels);
  if (image.step < line) return err(PictureFault::StepTooShort);
  // The last row needs no padding.
  if (image.data.size() < std::size_t{image.step} * (image.height - 1) + line) return err(PictureFault::DataTooShort);
  return Picture{image.data.data(), image.width, image.height, image.step, *found};
}

std::string explain(PictureFault fault, const sensor_msgs::msg::Image& image, std::span<const Encoding> known,
                    std::uint32_t least_side) {
  switch (fault) {
    case PictureFault::UnknownEncoding: {
      std::string names;
      for (const Encoding& one : known) names.append(names.empty() ? "" : ", ").append(one.name);
      return fmt::format("the encoding is '{}'; it must be one of {}", image.encoding.substr(0, kMostNameShown), names);
    }
    case PictureFault::BadSize:
      return fmt::format("the size is {} x {} pixels; sides must be from {} to {}, with {} pixels at most", image.width,
                         image.height, std::max(least_side, 1U), kMostSide, kMostPixels);
    case PictureFault::StepTooShort:
      return fmt::format("a row has {} bytes (step), too few for {} pixels of {}", image.step, image.width,
                         image.encoding.substr(0, kMostNameShown));
    case PictureFault::DataTooShort:
      return fmt::format("the data has {} bytes, too few for {} rows of {} bytes", image.data.size(), image.height,
                         image.step);
  }
  return "it cannot be read";
}

void set_shape(sensor_msgs::msg::Image& image, std::uint32_t width, std::uint32_t height, const Encoding& encoding) {
  image.width = width;
  image.height = height;
  image.encoding.assign(encoding.name);
  image.is_bigendian = 0;
  image.step = width * static_cast<std::uint32_t>(encoding.channels);
  image.data.resize_uninitialized(std::size_t{image.step} * height);
}

}  // namespace nacelle::image_proc
