// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "camera/port/capture_port.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/camera_info.hpp"

namespace nacelle::camera {

/// The path that a camera_info_url means, with ${NAME} and ${ROS_HOME} replaced.
/// Errors: package:// and flash: (there is no package index and no camera memory here), and texts that are no URL.
[[nodiscard]] Result<std::string, Problem> calibration_path(const std::string& url, const std::string& camera_name);

/// Whether the calibration can be read and understood, before there is a camera. A path with ${NAME} is not looked at, since the
/// camera says what its name is. An empty file is a calibration to come. Errors: as stream_info().
[[nodiscard]] Result<void, Problem> check_calibration(const std::string& url);

/// What goes into camera_info for a stream: the file's calibration, the known lens of a drawn picture, or the size
/// alone.
///
/// A calibration of another size is of no use; the size alone is published then, as v4l2_camera does, and `remark` says
/// so. The same for an empty file, which is a calibration to come.
/// Errors: a URL or file that cannot be read.
struct StreamInfo {
  sensor_msgs::msg::CameraInfo info;
  std::string remark;
};
[[nodiscard]] Result<StreamInfo, Problem> stream_info(const std::string& url, const CaptureFormat& format);

/// Checks a calibration for images of that format and writes it to the file that the URL means, whole or not at all. The file keeps
/// its mode. Returns its path. Blocks until the disk has the file.
/// Errors: a CalibrationFault or a FileFault; the file is then as it was.
[[nodiscard]] Result<std::string, Problem> store_calibration(const std::string& url, const CaptureFormat& format,
                                                             const sensor_msgs::msg::CameraInfo& info);

}  // namespace nacelle::camera
