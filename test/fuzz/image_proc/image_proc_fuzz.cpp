// SPDX-License-Identifier: Apache-2.0
// Any bytes as an Image and a CameraInfo: nothing crashes or reads and writes outside, each fault has a text, and what is taken gives
// the same result again.
//
//   offset  bytes  field
//        0      1  encoding (kEncodings), and whether it is debayered
//        1     12  width, height, step
//       13      1  interpolation, 3 bits; number of coefficients, 4 bits
//       14      1  width and height of the resized picture, 4 bits each
//       15     32  focal length, centre u, first and second coefficient, as doubles
//       47      -  pixels
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "image_proc/model/debayer.hpp"
#include "image_proc/model/jpeg_encoder.hpp"
#include "image_proc/model/rectification.hpp"
#include "image_proc/model/resizer.hpp"

namespace {

using namespace nacelle::image_proc;
using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;

constexpr std::array<const char*, 12> kEncodings{"mono8",       "rgb8",        "bgr8",        "rgba8",
                                                 "bgra8",       "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8",
                                                 "bayer_grbg8", "yuyv",        "16UC1",       ""};
constexpr std::size_t kHeader = 47;

void require(bool holds) {
  if (!holds) std::abort();
}

template <typename T>
T load(const std::uint8_t* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

// Of the exact size, so that the address sanitizer sees the first byte too many.
std::vector<std::uint8_t> room(std::uint32_t width, std::uint32_t height, int channels) {
  return std::vector<std::uint8_t>(std::size_t{width} * height * static_cast<std::size_t>(channels));
}

CameraInfo camera_info(const std::uint8_t* data, const Picture& picture) {
  CameraInfo info;
  info.width = picture.width;
  info.height = picture.height;
  const std::size_t coefficients = data[13] >> 4U;
  info.distortion_model = coefficients > 5 ? "rational_polynomial" : "plumb_bob";
  info.d.assign(coefficients, load<double>(data + 39));
  if (!info.d.empty()) info.d[0] = load<double>(data + 31);
  info.k = {load<double>(data + 15), 0, load<double>(data + 23), 0, load<double>(data + 15), 4, 0, 0, 1};
  info.p = {load<double>(data + 31), 0, 3, 0, 0, load<double>(data + 15), 3, 0, 0, load<double>(data + 23), 1, 0};
  return info;
}

void process(const std::uint8_t* data, const Picture& picture) {
  static JpegEncoder encoder;  // one for all inputs, as in a stream
  const int channels = picture.encoding.channels;
  const auto interpolation = static_cast<Interpolation>((data[13] & 7U) % 5);
  if (const auto map = rectification_map(camera_info(data, picture), interpolation)) {
    auto first = room(picture.width, picture.height, channels), second = first;
    map->apply(picture, first.data());
    map->apply(picture, second.data());
    require(first == second);
  } else {
    require(*to_text(map.error()) != '\0');
  }
  const SamplingMap::Size size{1U + (data[14] & 15U), 1U + (data[14] >> 4U)};
  auto resized = room(size.width, size.height, channels);
  Resizer{interpolation}.resize(picture, size, resized.data());
  nacelle::Buffer<std::uint8_t> first, second;
  require(encoder.encode(picture, 1 + data[13] % 100, first).has_value());
  require(encoder.encode(picture, 1 + data[13] % 100, second).has_value());
  require(first == second && first.size() > 100);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kHeader) return 0;
  Image image;
  image.encoding = kEncodings[data[0] % kEncodings.size()];
  image.width = load<std::uint32_t>(data + 1);
  image.height = load<std::uint32_t>(data + 5);
  image.step = load<std::uint32_t>(data + 9);
  std::vector<std::uint8_t> pixels(data + kHeader,
                                   data + size);  // not the buffer's own: no capacity behind the last pixel
  image.data.adopt(pixels.data(), pixels.size(), pixels.size(), {});
  if (const auto picture = picture_of(image, plain_encodings())) {
    process(data, *picture);
  } else {
    require(!explain(picture.error(), image, plain_encodings()).empty());
  }
  if (const auto mosaic = picture_of(image, mosaic_encodings(), kLeastMosaicSide)) {
    for (const auto& to : plain_encodings().first(3)) {  // mono8, rgb8, bgr8
      auto first = room(image.width, image.height, to.channels), second = first;
      debayer(*mosaic, to, first.data());
      debayer(*mosaic, to, second.data());
      require(first == second);
    }
  } else {
    require(!explain(mosaic.error(), image, mosaic_encodings(), kLeastMosaicSide).empty());
  }
  return 0;
}
