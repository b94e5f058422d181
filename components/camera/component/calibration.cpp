// SPDX-License-Identifier: Apache-2.0
#include "camera/component/calibration.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

#include "camera/protocol/calibration_fault.hpp"
#include "camera/protocol/camera_info_writer.hpp"
#include "camera/protocol/camera_info_yaml.hpp"
#include "nacelle/base/file_fault.hpp"
#include "nacelle/base/files.hpp"

namespace nacelle::camera {
namespace {

constexpr std::size_t kMostCalibrationBytes = std::size_t{1} << 20U;

std::string ros_home() {
  if (const char* const home = std::getenv("ROS_HOME"); home != nullptr && *home != '\0') return home;
  const char* const home = std::getenv("HOME");
  return std::string(home == nullptr ? "" : home) + "/.ros";
}

void replace_all(std::string& text, std::string_view from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

Result<std::string, Problem> calibration_text(const std::string& path) {
  auto text = read_regular_file(path, kMostCalibrationBytes);
  if (!text)
    return err(Problem{Place::of_parameter("camera_info_url"), "the calibration " + path + " " + text.error().what,
                       text.error().way_out, text.error().code, path});
  return text;
}

/// The file was made for set_camera_info to fill.
bool is_to_come(std::string_view text) { return text.find_first_not_of(" \t\r\n") == std::string_view::npos; }

sensor_msgs::msg::CameraInfo size_alone(const CaptureFormat& format) {
  sensor_msgs::msg::CameraInfo info;
  info.width = format.width;
  info.height = format.height;
  return info;
}

sensor_msgs::msg::CameraInfo ideal_lens(const CaptureFormat& format) {
  sensor_msgs::msg::CameraInfo info = size_alone(format);
  const Pinhole& lens = *format.lens;
  info.distortion_model = "plumb_bob";
  info.d = {0, 0, 0, 0, 0};
  info.k = {lens.focal_px, 0, lens.centre_u_px, 0, lens.focal_px, lens.centre_v_px, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {lens.focal_px, 0, lens.centre_u_px, 0, 0, lens.focal_px, lens.centre_v_px, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace

Result<std::string, Problem> calibration_path(const std::string& url, const std::string& camera_name) {
  const Place where = Place::of_parameter("camera_info_url");
  if (url.rfind("package://", 0) == 0) {
    return err(Problem{where, fmt::format("'{}' needs ROS's package index, which is not here", url),
                       "write file:// and the whole path", CalibrationFault::UnsupportedUrl, url});
  }
  if (url.rfind("flash:", 0) == 0)
    return err(Problem{where, "a camera's own memory cannot be read", "write file:// and the whole path",
                       CalibrationFault::UnsupportedUrl, url});
  constexpr std::string_view kScheme = "file://";
  if (url.rfind(kScheme, 0) != 0 || url.size() <= kScheme.size() ||
      (url[kScheme.size()] != '/' && url[kScheme.size()] != '$')) {
    return err(Problem{where, fmt::format("'{}' is no URL of a file", url),
                       "write file:// and the whole path, as in file:///etc/nacelle/front.yaml",
                       CalibrationFault::UnsupportedUrl, url});
  }
  std::string path = url.substr(kScheme.size());
  replace_all(path, "${NAME}", camera_name);
  replace_all(path, "${ROS_HOME}", ros_home());
  return path;
}

Result<void, Problem> check_calibration(const std::string& url) {
  if (url.empty() || url.find("${NAME}") != std::string::npos) return {};
  const auto path = calibration_path(url, "");
  if (!path) return err(path.error());
  const auto text = calibration_text(*path);
  if (!text) return err(text.error());
  if (is_to_come(*text)) return {};
  const auto calibration = parse_camera_info(*text, *path);
  if (!calibration) return err(calibration.error());
  return {};
}

Result<StreamInfo, Problem> stream_info(const std::string& url, const CaptureFormat& format) {
  if (url.empty()) return StreamInfo{format.lens ? ideal_lens(format) : size_alone(format), {}};
  const auto path = calibration_path(url, format.camera_name);
  if (!path) return err(path.error());
  const auto text = calibration_text(*path);
  if (!text) return err(text.error());
  if (is_to_come(*text)) {
    return StreamInfo{size_alone(format),
                      fmt::format("{} is empty: camera_info is without a calibration until the service "
                                  "set_camera_info is called",
                                  *path)};
  }
  auto calibration = parse_camera_info(*text, *path);
  if (!calibration) return err(calibration.error());
  const auto& info = calibration->info;
  if (info.width != format.width || info.height != format.height) {
    return StreamInfo{size_alone(format),
                      fmt::format("{} is for {}x{} pixels, the images have {}x{}: camera_info is without a calibration",
                                  *path, info.width, info.height, format.width, format.height)};
  }
  return StreamInfo{info, {}};
}

Result<std::string, Problem> store_calibration(const std::string& url, const CaptureFormat& format,
                                               const sensor_msgs::msg::CameraInfo& info) {
  if (url.empty()) {
    return err(Problem{Place::of_parameter("camera_info_url"), "is empty, so there is no file for a calibration",
                       "name a file that the robot's user may write, as in file:///var/lib/nacelle/front.yaml, and "
                       "create it empty",
                       CalibrationFault::NoFile});
  }
  auto path = calibration_path(url, format.camera_name);
  if (!path) return path;
  if (auto fine = check_camera_info(info, format.width, format.height); !fine) return err(fine.error());
  const std::string text = camera_info_yaml({format.camera_name, info});
  if (auto written = write_whole_file(*path, text); !written) {
    Problem problem = written.error();
    if (problem.code == FileFault::NotPermitted)
      problem.way_out += " a robot that is a service may write to /var/lib/nacelle only, with StateDirectory=nacelle";
    return err(std::move(problem));
  }
  return path;
}

}  // namespace nacelle::camera
