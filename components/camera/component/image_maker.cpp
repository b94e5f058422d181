// SPDX-License-Identifier: Apache-2.0
#include "camera/component/image_maker.hpp"

#include <fmt/format.h>

#include <cstring>

#include "camera/port/camera_fault.hpp"
#include "camera/protocol/yuv.hpp"

namespace nacelle::camera {
namespace {

bool is_rgb(FourCc code) { return code == kRgb24 || code == kBgr24; }
bool is_yuv(FourCc code) { return code == kYuyv || code == kUyvy; }

bool can_become(FourCc from, FourCc to) {
  if (from == to) return true;
  if (is_jpeg(from) || is_yuv(from) || from == kNv12) return is_rgb(to) || to == kGrey;
  return is_rgb(from) && is_rgb(to);
}

}  // namespace

Result<ImageMaker, Problem> ImageMaker::make(const CaptureFormat& format, const PixelFormat& output) {
  if (!can_become(format.pixel_format, output.code)) {
    std::vector<std::string> possible;
    for (const auto* to = readable_formats_begin(); to != readable_formats_end(); ++to) {
      if (!to->encoding.empty() && can_become(format.pixel_format, to->code)) possible.emplace_back(to->encoding);
    }
    return err(Problem{Place::of_parameter("output_encoding"),
                       fmt::format("{} cannot be made from {}", output.encoding, to_text(format.pixel_format)),
                       "use " + join(possible, " or "), CameraFault::NotConvertible, std::string(output.encoding)});
  }
  return ImageMaker{format, output};
}

ImageMaker::ImageMaker(const CaptureFormat& format, const PixelFormat& output)
    : width_(format.width),
      height_(format.height),
      bytes_per_line_(format.bytes_per_line),
      from_(format.pixel_format),
      to_(output.code),
      output_(&output),
      frame_bytes_(format.frame_bytes),
      fills_offered_memory_(format.fills_offered_memory) {
  if (is_jpeg(from_)) decoder_ = std::make_unique<JpegDecoder>();
}

ByteSpan ImageMaker::room_in(sensor_msgs::msg::Image& image) const {
  if (!fills_offered_memory_) return {};
  image.data.resize_uninitialized(frame_bytes_);
  return {image.data.data(), frame_bytes_};
}

ImageMaker::Outcome ImageMaker::fill(const Frame& frame, sensor_msgs::msg::Image& image) {
  image.height = height_;
  image.width = width_;
  image.encoding.assign(output_->encoding);
  image.is_bigendian = 0;
  image.step = width_ * output_->bytes_per_pixel;
  if (from_ == to_) {
    image.step = bytes_per_line_;
    if (fills_offered_memory_) return Outcome::InPlace;
    if (frame.spare_buffers > kAlwaysQueued) {
      image.data.adopt(frame.bytes.data(), frame_bytes_, frame.bytes.size(), frame.give_back);
      return Outcome::Adopted;
    }
    image.data.resize_uninitialized(frame_bytes_);
    std::memcpy(image.data.data(), frame.bytes.data(), frame_bytes_);
    frame.return_memory();
    return Outcome::Copied;
  }
  image.data.resize_uninitialized(std::size_t{image.step} * height_);
  const bool good = convert(frame.bytes, {image.data.data(), image.data.size()});
  frame.return_memory();
  return good ? Outcome::Converted : Outcome::Undecodable;
}

bool ImageMaker::convert(ByteView frame, ByteSpan out) {
  const PictureShape shape{width_, height_, bytes_per_line_};
  if (is_jpeg(from_)) {
    const auto colours = to_ == kGrey ? JpegColours::Mono : to_ == kRgb24 ? JpegColours::Rgb : JpegColours::Bgr;
    return decoder_->decode(frame, width_, height_, colours, out).has_value();
  }
  if (is_yuv(from_)) {
    const auto order = from_ == kYuyv ? YuvOrder::Yuyv : YuvOrder::Uyvy;
    if (to_ == kGrey) return yuv_to_mono(frame, shape, order, out);
    return yuv_to_rgb(frame, shape, order, to_ == kRgb24 ? RgbOrder::Rgb : RgbOrder::Bgr, out);
  }
  if (from_ == kNv12) {
    if (to_ == kGrey) return nv12_to_mono(frame, shape, out);
    return nv12_to_rgb(frame, shape, to_ == kRgb24 ? RgbOrder::Rgb : RgbOrder::Bgr, out);
  }
  return swap_red_blue(frame, shape, out);
}

}  // namespace nacelle::camera
