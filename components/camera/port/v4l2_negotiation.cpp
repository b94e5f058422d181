// SPDX-License-Identifier: Apache-2.0
#include "camera/port/v4l2_negotiation.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "camera/port/camera_fault.hpp"

namespace nacelle::camera {
namespace {

// Enumerations end with EINVAL; a broken driver's may not.
constexpr std::uint32_t kMostEntries = 1000;
constexpr std::uint32_t kMostPixels = 16384;  // a side

template <std::size_t kSize>
std::string text_of(const __u8 (&field)[kSize]) {
  const auto* const begin = reinterpret_cast<const char*>(field);
  return {begin, ::strnlen(begin, kSize)};
}

std::vector<FourCc> offered_formats(const V4l2Device& device) {
  std::vector<FourCc> codes;
  for (std::uint32_t index = 0; index < kMostEntries; ++index) {
    v4l2_fmtdesc entry{};
    entry.index = index;
    entry.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (device.call(VIDIOC_ENUM_FMT, entry) != 0) break;
    codes.push_back(entry.pixelformat);
  }
  return codes;
}

// "640x480, 1280x720 or 160x120 to 1920x1080": for remarks.
std::string offered_sizes(const V4l2Device& device, FourCc code) {
  std::vector<std::string> sizes;
  for (std::uint32_t index = 0; index < kMostEntries; ++index) {
    v4l2_frmsizeenum entry{};
    entry.index = index;
    entry.pixel_format = code;
    if (device.call(VIDIOC_ENUM_FRAMESIZES, entry) != 0) break;
    if (entry.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      sizes.push_back(fmt::format("{}x{} to {}x{}", entry.stepwise.min_width, entry.stepwise.min_height,
                                  entry.stepwise.max_width, entry.stepwise.max_height));
      break;
    }
    sizes.push_back(fmt::format("{}x{}", entry.discrete.width, entry.discrete.height));
  }
  return join(sizes);
}

std::string names_of(const std::vector<FourCc>& codes) {
  std::vector<std::string> names;
  for (const FourCc code : codes) names.push_back(to_text(code));
  return join(names);
}

Result<FourCc, Problem> choose_format(const V4l2Device& device, const CaptureWish& wish, CaptureFormat& format) {
  const std::vector<FourCc> offered = offered_formats(device);
  const auto has = [&](FourCc code) { return std::find(offered.begin(), offered.end(), code) != offered.end(); };
  if (has(wish.pixel_format)) return wish.pixel_format;
  const auto* const chosen =
      std::find_if(readable_formats_begin(), readable_formats_end(), [&](const auto& f) { return has(f.code); });
  if (chosen == readable_formats_end()) {
    return err(Problem{
        wish.device,
        fmt::format("offers no pixel format that can be read, only {}", offered.empty() ? "none" : names_of(offered)),
        "a camera on a ribbon cable gives raw sensor data here: video_device:=libcamera processes it; "
        "video_device:=pattern needs no camera",
        CameraFault::UnreadableFormat, names_of(offered)});
  }
  format.remarks.push_back(fmt::format("pixel_format {} is not offered ({}); {} is used", to_text(wish.pixel_format),
                                       names_of(offered), to_text(chosen->code)));
  return chosen->code;
}

void agree_on_rate(const V4l2Device& device, const CaptureWish& wish, CaptureFormat& format) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (device.call(VIDIOC_G_PARM, parameters) != 0) return;
  if ((parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) != 0 && wish.period_num != 0 &&
      wish.period_den != 0) {
    parameters.parm.capture.timeperframe = {wish.period_num, wish.period_den};
    // Refused while another program streams, for example. The rate then stays unchanged.
    static_cast<void>(device.call(VIDIOC_S_PARM, parameters));
  }
  const v4l2_fract period = parameters.parm.capture.timeperframe;
  if (period.numerator == 0 || period.denominator == 0) return;
  format.frame_period = from_seconds(std::min(3600.0, static_cast<double>(period.numerator) / period.denominator));
  if (wish.period_num == 0 || wish.period_den == 0) return;
  const double wished_s = static_cast<double>(wish.period_num) / wish.period_den;
  if (std::abs(to_seconds(format.frame_period) - wished_s) > 0.01 * wished_s) {
    format.remarks.push_back(fmt::format("time_per_frame [{}, {}] is not offered; [{}, {}] is used", wish.period_num,
                                         wish.period_den, period.numerator, period.denominator));
  }
}

}  // namespace

Problem describe_trouble(const std::string& device, std::string_view step, int os_code) {
  const int code = -os_code;
  std::string way_out;
  CameraFault fault{};
  switch (code) {
    case ENOENT:
      fault = CameraFault::NotThere;
      way_out =
          "is the camera plugged in? `ls /dev/v4l/by-id` shows what is there; video_device:=pattern needs no device";
      break;
    case ENODEV:
    case ENXIO:
      fault = CameraFault::Unplugged;
      way_out = "it was unplugged; plug it in again";
      break;
    case EACCES:
    case EPERM:
      fault = CameraFault::NotPermitted;
      way_out = "add the user to the group video: `sudo adduser $USER video`, then log in again";
      break;
    case EBUSY:
      fault = CameraFault::Busy;
      way_out = "another program uses it; `fuser -v " + device + "` names it";
      break;
    case ENOSPC:
      fault = CameraFault::NoBandwidth;
      way_out = "the USB bus has no bandwidth left; choose a smaller image_size, pixel_format MJPG, or another port";
      break;
    case ENOMEM:
      fault = CameraFault::NoMemory;
      way_out = "no memory for its buffers; choose a smaller image_size";
      break;
    case EPIPE:
      fault = CameraFault::NeedsLibcamera;
      way_out = "its media pipeline is not linked: use video_device:=libcamera";
      break;
    case ENOTTY:
    case EINVAL:
      fault = CameraFault::NotACamera;
      way_out = "is it a camera that captures video? `v4l2-ctl --list-devices` tells";
      break;
    case ERANGE:
      fault = CameraFault::OutOfRange;
      way_out = "the value is out of the control's range";
      break;
    default: fault = CameraFault::Failed; way_out = "see `dmesg`, or unplug and plug the camera";
  }
  return {device, fmt::format("{} failed: {} (errno {})", step, std::generic_category().message(code), code), way_out,
          fault};
}

Problem describe_start(const CaptureWish& wish, std::string_view step, int os_code) {
  const bool refused = os_code == -EINVAL || os_code == -ENOTTY || os_code == -EFAULT || os_code == -ENOBUFS;
  if (wish.memory == FrameMemory::Mapped || !refused) return describe_trouble(wish.device, step, os_code);
  const bool own = wish.memory == FrameMemory::Own;
  return {wish.device,
          fmt::format("the driver does not take frame memory of {} ({}: errno {})",
                      own ? "this process" : "another device", step, -os_code),
          own ? "use io_method mmap" : "give as many dma-bufs as the driver asks for, each as large as a frame",
          CameraFault::MemoryRefused};
}

Result<CaptureFormat, Problem> negotiate(const V4l2Device& device, const CaptureWish& wish) {
  v4l2_capability capability{};
  if (const int answer = device.call(VIDIOC_QUERYCAP, capability); answer != 0) {
    return err(describe_trouble(wish.device, "QUERYCAP", answer));
  }
  // `capabilities` is the whole card's, device_caps this node's: a webcam's second node has metadata only.
  const std::uint32_t can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) {
    return err(Problem{
        wish.device,
        fmt::format("is not a camera that streams ('{}', capabilities {:#010x})", text_of(capability.card), can),
        "a camera has several nodes; the one with index0 in /dev/v4l/by-id captures", CameraFault::NotACamera});
  }
  CaptureFormat agreed;
  agreed.camera_name = parameter_name(text_of(capability.card));
  auto code = choose_format(device, wish, agreed);
  if (!code) return err(code.error());

  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = wish.width;
  format.fmt.pix.height = wish.height;
  format.fmt.pix.pixelformat = *code;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (const int answer = device.call(VIDIOC_S_FMT, format); answer != 0)
    return err(describe_trouble(wish.device, "S_FMT", answer));
  const v4l2_pix_format& given = format.fmt.pix;
  const PixelFormat* const layout = find_pixel_format(given.pixelformat);
  if (layout == nullptr) {
    return err(Problem{
        wish.device, fmt::format("insists on pixel format {}, which cannot be read", to_text(given.pixelformat)),
        "choose another image_size or pixel_format", CameraFault::UnreadableFormat, to_text(given.pixelformat)});
  }
  if (given.width == 0 || given.height == 0 || given.width > kMostPixels || given.height > kMostPixels) {
    return err(Problem{wish.device, fmt::format("answers with a picture of {}x{}", given.width, given.height),
                       "choose another image_size", CameraFault::UnusableSize,
                       fmt::format("{}x{}", given.width, given.height)});
  }
  agreed.pixel_format = given.pixelformat;
  agreed.width = given.width;
  agreed.height = given.height;
  if (layout->bytes_per_pixel != 0) {
    // Some drivers leave bytesperline at 0; less than a line's bytes is nonsense, too.
    agreed.bytes_per_line = std::max(given.bytesperline, given.width * layout->bytes_per_pixel);
    agreed.frame_bytes = std::size_t{agreed.bytes_per_line} * agreed.height * layout->lines_for_two / 2;
  } else {
    agreed.frame_bytes = given.sizeimage;
  }
  if (given.width != wish.width || given.height != wish.height) {
    agreed.remarks.push_back(fmt::format("image_size [{}, {}] is not offered ({}); [{}, {}] is used", wish.width,
                                         wish.height, offered_sizes(device, given.pixelformat), given.width,
                                         given.height));
  }
  agree_on_rate(device, wish, agreed);
  return agreed;
}

std::vector<Control> list_controls(const V4l2Device& device) {
  std::vector<Control> controls;
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (std::uint32_t i = 0; i < kMostEntries && device.call(VIDIOC_QUERYCTRL, query) == 0;
       ++i, query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    const bool number = query.type == V4L2_CTRL_TYPE_INTEGER || query.type == V4L2_CTRL_TYPE_MENU ||
                        query.type == V4L2_CTRL_TYPE_INTEGER_MENU || query.type == V4L2_CTRL_TYPE_BITMASK;
    if ((!number && query.type != V4L2_CTRL_TYPE_BOOLEAN) || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    Control control;
    control.id = query.id;
    control.name = parameter_name(text_of(query.name));
    control.is_switch = query.type == V4L2_CTRL_TYPE_BOOLEAN;
    control.read_only = (query.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0;
    control.least = query.minimum;
    control.most = query.maximum;
    control.step = static_cast<std::uint64_t>(std::max(query.step, 0));
    v4l2_control value{};
    value.id = query.id;
    control.value = device.call(VIDIOC_G_CTRL, value) == 0 ? value.value : query.default_value;
    if (!control.name.empty()) controls.push_back(std::move(control));
  }
  return controls;
}

std::string parameter_name(std::string_view control_name) {
  std::string name;
  for (const char c : control_name) {
    if (c == ',' || c == '(' || c == ')') continue;
    const bool letter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    const bool digit = c >= '0' && c <= '9';
    name += letter ? static_cast<char>(c | 0x20) : digit ? c : '_';
  }
  return name;
}

}  // namespace nacelle::camera
