// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "camera/port/capture_port.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::camera {

/// Where images come from.
enum class Source : std::uint8_t {
  V4l2,
  Libcamera,  ///< What needs processing by this computer, such as the Raspberry Pi's CSI cameras.
  Pattern     ///< A drawn scene; needs no device.
};

/// The values of video_device that stand for Source::Pattern and for Source::Libcamera: the latter's first camera, or the one whose
/// id or number follows a colon.
inline constexpr const char *kPattern = "pattern", *kLibcamera = "libcamera";

/// The camera's parameters as written: v4l2_camera's names and defaults.
struct CameraOptions {
  std::string video_device = "/dev/video0";  ///< Or kPattern.
  std::string pixel_format = "YUYV";
  std::string output_encoding = "rgb8";
  std::string io_method = "mmap";
  std::vector<std::int64_t> image_size{640, 480};
  std::vector<std::int64_t> time_per_frame{1, 30};  ///< Seconds, as a fraction.
  std::string camera_frame_id = "camera_optical_frame";
  std::string camera_info_url;
  bool use_v4l2_buffer_timestamps = true;
  std::int64_t timestamp_offset_ns = 0;
};

/// What checked options mean.
struct CameraSetup {
  Source source = Source::V4l2;
  CaptureWish wish;  ///< For a device.
  const PixelFormat* output = nullptr;
};

/// Declares every parameter on the node. Errors: rclcpp's named exceptions.
[[nodiscard]] CameraOptions declare_options(Node& node);
/// Checks all options. Errors: the first Problem, with parameter, value, allowed values and the way out; `node` is the node
/// of the options.
[[nodiscard]] Result<CameraSetup, Problem> validated(const CameraOptions& options, const std::string& node);

}  // namespace nacelle::camera
