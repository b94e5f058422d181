// SPDX-License-Identifier: Apache-2.0
#include "camera/port/libcamera_agreement.hpp"

#include <fmt/format.h>
#include <libcamera/color_space.h>
#include <libcamera/control_ids.h>
#include <libcamera/property_ids.h>

#include <algorithm>
#include <string>
#include <vector>

#include "camera/model/drm_format.hpp"
#include "camera/port/camera_fault.hpp"
#include "camera/port/v4l2_negotiation.hpp"

namespace nacelle::camera {
namespace {

namespace controls = ::libcamera::controls;

constexpr std::uint32_t kMostPixels = 16384;  // of a side

std::vector<FourCc> formats_of(const ::libcamera::StreamConfiguration& stream) {
  std::vector<FourCc> all;
  for (const auto& format : stream.formats().pixelformats()) {
    if (format.modifier() == 0) all.push_back(v4l2_of(format.fourcc()));  // a modifier: compressed, or of packed bits
  }
  return all;
}

std::string names_of(const std::vector<FourCc>& codes) {
  std::vector<std::string> names;
  for (const FourCc code : codes) names.push_back(to_text(code));
  return names.empty() ? "none" : join(names);
}

std::string sizes_of(const ::libcamera::StreamConfiguration& stream) {
  std::vector<std::string> names;
  for (const auto& size : stream.formats().sizes(stream.pixelFormat)) names.push_back(size.toString());
  return names.empty() ? stream.formats().range(stream.pixelFormat).toString() : join(names);
}

Result<FourCc, Problem> choose_format(const ::libcamera::StreamConfiguration& stream, const CaptureWish& wish,
                                      CaptureFormat& format) {
  const std::vector<FourCc> offered = formats_of(stream);
  const auto has = [&](FourCc code) { return std::find(offered.begin(), offered.end(), code) != offered.end(); };
  if (has(wish.pixel_format)) return wish.pixel_format;
  const auto* const chosen = std::find_if(readable_formats_begin(), readable_formats_end(),
                                          [&](const auto& known) { return has(known.code); });
  if (chosen == readable_formats_end()) {
    return err(Problem{wish.device, "offers no pixel format that can be read, only " + names_of(offered),
                       "`cam -c " + wish.device + " -I` lists what it offers", CameraFault::UnreadableFormat,
                       names_of(offered)});
  }
  format.remarks.push_back(fmt::format("pixel_format {} is not offered ({}); {} is used", to_text(wish.pixel_format),
                                       names_of(offered), to_text(chosen->code)));
  return chosen->code;
}

/// The camera's frame time; limits are those of the agreed size only after it is configured, so the camera itself has the last word.
void agree_on_rate(const ::libcamera::Camera& camera, const CaptureWish& wish, Agreement& agreed) {
  const auto limits = camera.controls().find(controls::FRAME_DURATION_LIMITS);
  if (limits == camera.controls().end() || wish.period_num == 0 || wish.period_den == 0) return;
  const std::int64_t wished_us = std::int64_t{1'000'000} * wish.period_num / wish.period_den;
  const auto bound = [](const ::libcamera::ControlValue& value, std::int64_t otherwise) {
    return value.type() == ::libcamera::ControlTypeInteger64 && !value.isArray() ? value.get<std::int64_t>()
                                                                                 : otherwise;
  };
  const std::int64_t least = bound(limits->second.min(), wished_us);
  const std::int64_t most = std::max(least, bound(limits->second.max(), wished_us));
  const std::int64_t used_us = std::clamp(wished_us, least, most);
  if (used_us != wished_us) {
    agreed.format.remarks.push_back(fmt::format("time_per_frame [{}, {}] is not offered ({} to {} us); {} us is used",
                                                wish.period_num, wish.period_den, least, most, used_us));
  }
  agreed.frame_time_us = used_us;
  agreed.format.frame_period = std::chrono::microseconds{used_us};
}

}  // namespace

Result<Agreement, Problem> agree(::libcamera::Camera& camera, const CaptureWish& wish, unsigned buffers) {
  Agreement agreed;
  const auto role = is_bayer(wish.pixel_format) ? ::libcamera::StreamRole::Raw : ::libcamera::StreamRole::Viewfinder;
  agreed.configuration = camera.generateConfiguration({role});
  if (agreed.configuration == nullptr || agreed.configuration->empty())
    return err(Problem{wish.device, "offers no stream of this kind", "choose another pixel_format",
                       CameraFault::UnreadableFormat, to_text(wish.pixel_format)});
  CaptureFormat& format = agreed.format;
  const auto model = camera.properties().get(::libcamera::properties::Model);
  format.camera_name = parameter_name(model ? std::string_view{*model} : std::string_view{camera.id()});
  auto& stream = agreed.configuration->at(0);
  auto code = choose_format(stream, wish, format);
  if (!code) return err(code.error());
  stream.pixelFormat = ::libcamera::PixelFormat{drm_of(*code)};
  stream.size = {wish.width, wish.height};
  stream.bufferCount = buffers;
  // What yuv.hpp converts from: BT.601, full range.
  if (*code == kYuyv || *code == kUyvy || *code == kNv12) stream.colorSpace = ::libcamera::ColorSpace::Sycc;
  if (agreed.configuration->validate() == ::libcamera::CameraConfiguration::Invalid)
    return err(Problem{wish.device, fmt::format("refuses {}x{} {}", wish.width, wish.height, to_text(*code)),
                       "choose another image_size or pixel_format: " + sizes_of(stream), CameraFault::UnusableSize,
                       fmt::format("{}x{}", wish.width, wish.height)});

  format.pixel_format = v4l2_of(stream.pixelFormat.fourcc());
  const PixelFormat* const layout = find_pixel_format(format.pixel_format);
  if (layout == nullptr || stream.pixelFormat.modifier() != 0)
    return err(Problem{
        wish.device, "insists on pixel format " + stream.pixelFormat.toString() + ", which cannot be read",
        "choose another image_size or pixel_format", CameraFault::UnreadableFormat, stream.pixelFormat.toString()});
  format.width = stream.size.width;
  format.height = stream.size.height;
  if (format.width == 0 || format.height == 0 || format.width > kMostPixels || format.height > kMostPixels)
    return err(Problem{wish.device, "answers with a picture of " + stream.size.toString(), "choose another image_size",
                       CameraFault::UnusableSize, stream.size.toString()});
  if (layout->bytes_per_pixel != 0) {
    format.bytes_per_line = std::max(stream.stride, format.width * layout->bytes_per_pixel);
    format.frame_bytes = std::size_t{format.bytes_per_line} * format.height * layout->lines_for_two / 2;
  } else {
    format.frame_bytes = stream.frameSize;
  }
  if (format.width != wish.width || format.height != wish.height) {
    format.remarks.push_back(fmt::format("image_size [{}, {}] is not offered ({}); [{}, {}] is used", wish.width,
                                         wish.height, sizes_of(stream), format.width, format.height));
  }
  agree_on_rate(camera, wish, agreed);
  return agreed;
}

}  // namespace nacelle::camera
