// SPDX-License-Identifier: Apache-2.0
#include "look/component/picture_maker.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "image_proc/model/picture.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::look {
namespace {

using image_proc::Encoding;
using image_proc::Picture;

constexpr std::uint32_t kMostWidth = 640;
constexpr int kQuality = 75;
/// `channels`: bytes from one pixel to the next; the brightness is one of them.
constexpr std::array<Encoding, 8> kGrey{{{"yuv422", 2},
                                         {"uyvy", 2},
                                         {"yuv422_yuy2", 2},
                                         {"yuyv", 2},
                                         {"bayer_rggb8", 1},
                                         {"bayer_bggr8", 1},
                                         {"bayer_gbrg8", 1},
                                         {"bayer_grbg8", 1}}};

/// Which bytes of a pixel are shown.
struct Shown {
  std::size_t first = 0, count = 1;
  std::uint32_t least_factor = 1;
};

Shown shown_of(const Encoding& encoding) {
  if (encoding.name.starts_with("bayer")) return {0, 1, 2};  // the mean of a pattern
  if (encoding.name == "yuv422" || encoding.name == "uyvy") return {1, 1, 1};
  if (encoding.channels == 2) return {0, 1, 1};
  return {0, static_cast<std::size_t>(encoding.channels), 1};
}

/// Each byte of `out` is the mean of factor x factor bytes.
void shrink(const Picture& picture, const Shown& shown, std::uint32_t factor, std::uint32_t width, std::uint32_t height,
            std::uint8_t* out) {
  const auto stride = static_cast<std::size_t>(picture.encoding.channels);
  const std::uint32_t area = factor * factor;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::uint8_t* const corner =
          picture.pixels + std::size_t{y} * factor * picture.step + std::size_t{x} * factor * stride;
      for (std::size_t channel = 0; channel < shown.count; ++channel) {
        std::uint32_t sum = area / 2;
        for (std::uint32_t row = 0; row < factor; ++row) {
          const std::uint8_t* at = corner + row * picture.step + shown.first + channel;
          for (std::uint32_t column = 0; column < factor; ++column, at += stride) sum += *at;
        }
        *out++ = static_cast<std::uint8_t>(sum / area);
      }
    }
  }
}

}  // namespace

Result<Bytes, std::string> PictureMaker::make(const sensor_msgs::msg::Image& image) {
  auto picture = picture_of(image, image_proc::plain_encodings());
  if (!picture) picture = picture_of(image, kGrey);
  if (!picture) return err(explain(picture.error(), image, image_proc::plain_encodings()));
  const Shown shown = shown_of(picture->encoding);
  const std::uint32_t factor = std::max(shown.least_factor, (picture->width + kMostWidth - 1) / kMostWidth);
  const std::uint32_t width = picture->width / factor, height = picture->height / factor;
  if (width == 0 || height == 0) return err(std::string{"the picture is too small"});
  Picture small = *picture;
  if (factor > 1 || shown.count != static_cast<std::size_t>(picture->encoding.channels)) {
    pixels_.resize(std::size_t{width} * height * shown.count);
    shrink(*picture, shown, factor, width, height, pixels_.data());
    small = {pixels_.data(), width, height, std::size_t{width} * shown.count,
             shown.count == 1 ? image_proc::plain_encodings()[0] : picture->encoding};
  }
  if (const auto done = encoder_.encode(small, kQuality, made_.data); !done)
    return err(std::string{to_text(done.error())});
  made_.header = image.header;
  made_.format = "jpeg";
  const auto& type = sensor_msgs::msg::CompressedImage::message_type();
  Bytes bytes(type.encoded_size(&made_));
  type.encode(&made_, bytes.data());
  return bytes;
}

}  // namespace nacelle::look
