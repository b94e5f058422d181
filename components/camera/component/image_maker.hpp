// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "camera/port/capture_port.hpp"
#include "camera/protocol/jpeg_decoder.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/image.hpp"

namespace nacelle::camera {

/// Turns frames of one format into images of one encoding.
///
/// Where both are the same, the image takes over the frame's memory, hook included: no byte is copied. Otherwise one
/// pass goes from the frame straight into the image's own memory.
/// Threads: one at a time. Allocates: nothing once the images have grown to size.
class ImageMaker {
 public:
  /// Errors: a Problem listing the encodings that this format can become.
  [[nodiscard]] static Result<ImageMaker, Problem> make(const CaptureFormat& format, const PixelFormat& output);

  /// What happened to a frame. In every case its memory is given back or belongs to the image.
  enum class Outcome : std::uint8_t {
    Adopted,      ///< The image holds the frame's memory.
    InPlace,      ///< The port wrote into the image already.
    Converted,    ///< One pass to another layout.
    Copied,       ///< Same layout, but readers hold all buffers but those that stay with the device (kAlwaysQueued).
    Undecodable,  ///< The JPEG is broken; the image is not to be published.
  };
  /// Fills every field of the image but its header.
  [[nodiscard]] Outcome fill(const Frame& frame, sensor_msgs::msg::Image& image);

  /// Returns memory of the image for a port that fills offered memory; empty for other ports.
  [[nodiscard]] ByteSpan room_in(sensor_msgs::msg::Image& image) const;

 private:
  ImageMaker(const CaptureFormat& format, const PixelFormat& output);
  [[nodiscard]] bool convert(ByteView frame, ByteSpan out);

  std::uint32_t width_, height_, bytes_per_line_;
  FourCc from_, to_;
  const PixelFormat* output_;
  std::size_t frame_bytes_;
  bool fills_offered_memory_;
  std::unique_ptr<JpegDecoder> decoder_;
};

}  // namespace nacelle::camera
