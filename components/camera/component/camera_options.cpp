// SPDX-License-Identifier: Apache-2.0
#include "camera/component/camera_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::camera {
namespace {

ParameterDescriptor fixed(std::string description, std::string constraints = {}) {
  return {std::move(description), std::move(constraints), true, false, std::nullopt, std::nullopt};
}

Problem wrong(const std::string& node, const char* parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter, node), std::move(what), std::move(way_out)};
}

std::string listed(const std::vector<std::int64_t>& values) { return fmt::format("[{}]", fmt::join(values, ", ")); }

std::vector<std::string> encodings() {
  std::vector<std::string> names;
  std::for_each(readable_formats_begin(), readable_formats_end(), [&](const PixelFormat& format) {
    if (!format.encoding.empty()) names.emplace_back(format.encoding);
  });
  return names;
}

}  // namespace

CameraOptions declare_options(Node& node) {
  CameraOptions o;
  o.video_device = node.declare_parameter<std::string>(
      "video_device", o.video_device,
      fixed("The camera's node; a path in /dev/v4l/by-id names the same camera in any port.",
            "a path; libcamera or libcamera:ID; or pattern: a test pattern without a device"));
  o.pixel_format = node.declare_parameter<std::string>(
      "pixel_format", o.pixel_format, fixed("What the camera sends.", "a V4L2 name of four characters"));
  o.output_encoding = node.declare_parameter<std::string>(
      "output_encoding", o.output_encoding,
      fixed("What is published; equal to the camera's own (yuyv for YUYV) it costs no copy."));
  o.io_method = node.declare_parameter<std::string>(
      "io_method", o.io_method,
      fixed("Whose memory the driver writes into: its own, mapped, or this process's.", "mmap or userptr"));
  o.image_size = node.declare_parameter<std::vector<std::int64_t>>("image_size", o.image_size,
                                                                   fixed("Width and height in pixels."));
  o.time_per_frame = node.declare_parameter<std::vector<std::int64_t>>(
      "time_per_frame", o.time_per_frame, fixed("Seconds between frames, as numerator and denominator."));
  declare_frame_prefix(node);
  node.declare_parameter<std::string>("camera_frame_id", o.camera_frame_id,
                                      fixed("Frame of the headers: the optical one (x right, y down, z forward)."));
  o.camera_frame_id = frame_name(node, "camera_frame_id");
  o.camera_info_url = node.declare_parameter<std::string>(
      "camera_info_url", o.camera_info_url,
      fixed("The calibration, e.g. file:///etc/nacelle/front.yaml; empty: none.", "file:// only"));
  o.use_v4l2_buffer_timestamps =
      node.declare_parameter<bool>("use_v4l2_buffer_timestamps", o.use_v4l2_buffer_timestamps,
                                   fixed("Stamp with the kernel's time of capture; false: with the time of receipt."));
  o.timestamp_offset_ns = node.declare_parameter<std::int64_t>("timestamp_offset", o.timestamp_offset_ns,
                                                               fixed("Added to every stamp, in ns."));
  declare_device_parameters(node);
  return o;
}

Result<CameraSetup, Problem> validated(const CameraOptions& options, const std::string& node) {
  CameraSetup setup;
  if (options.video_device.empty())
    return err(wrong(node, "video_device", "is empty", "give a path such as /dev/video0, or pattern"));
  const bool of_libcamera = options.video_device == kLibcamera || options.video_device.rfind("libcamera:", 0) == 0;
  setup.source = options.video_device == kPattern ? Source::Pattern : of_libcamera ? Source::Libcamera : Source::V4l2;
  const auto code = parse_fourcc(options.pixel_format);
  if (!code || find_pixel_format(*code) == nullptr) {
    std::vector<std::string> known;
    std::for_each(readable_formats_begin(), readable_formats_end(),
                  [&](const auto& format) { known.push_back(to_text(format.code)); });
    return err(wrong(node, "pixel_format", fmt::format("'{}' cannot be read", options.pixel_format),
                     suggestion(options.pixel_format, known)));
  }
  setup.output = find_pixel_format(std::string_view{options.output_encoding});
  if (setup.output == nullptr) {
    return err(wrong(node, "output_encoding", fmt::format("'{}' cannot be published", options.output_encoding),
                     suggestion(options.output_encoding, encodings())));
  }
  if (options.io_method != "mmap" && options.io_method != "userptr")
    return err(wrong(node, "io_method", fmt::format("'{}' is unknown", options.io_method), "use mmap or userptr"));
  const auto side_ok = [](std::int64_t side) { return side >= 16 && side <= 16384; };
  if (options.image_size.size() != 2 || !side_ok(options.image_size[0]) || !side_ok(options.image_size[1])) {
    return err(wrong(node, "image_size", fmt::format("{} is not a size", listed(options.image_size)),
                     "give width and height, 16 to 16384 each, as in [640, 480]"));
  }
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  const auto part_ok = [](std::int64_t part) { return part > 0 && part <= kMost; };
  if (options.time_per_frame.size() != 2 || !part_ok(options.time_per_frame[0]) ||
      !part_ok(options.time_per_frame[1])) {
    return err(wrong(node, "time_per_frame", fmt::format("{} is not a time", listed(options.time_per_frame)),
                     "give numerator and denominator in seconds, as in [1, 30]"));
  }
  if (options.camera_frame_id.empty())
    return err(wrong(node, "camera_frame_id", "is empty", "name the optical frame, such as camera_optical_frame"));
  setup.wish.device = options.video_device;
  setup.wish.memory = options.io_method == "userptr" ? FrameMemory::Own : FrameMemory::Mapped;
  setup.wish.pixel_format = *code;
  setup.wish.width = static_cast<std::uint32_t>(options.image_size[0]);
  setup.wish.height = static_cast<std::uint32_t>(options.image_size[1]);
  setup.wish.period_num = static_cast<std::uint32_t>(options.time_per_frame[0]);
  setup.wish.period_den = static_cast<std::uint32_t>(options.time_per_frame[1]);
  return setup;
}

}  // namespace nacelle::camera
