// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/parameter_file.hpp"

namespace nacelle::ros_import {

/// The result of translating a parameter.
enum class Fate : std::uint8_t {
  Kept,        ///< Nacelle has it under the same name, with the same meaning.
  Translated,  ///< Another name, node or form, which `text` names.
  Dropped,     ///< Nothing in Nacelle needs it; `text` gives the reason.
  Doubted,     ///< The user must decide: a typing error, another meaning, or no counterpart.
  Added        ///< Not in the file: ROS's default, which differs from Nacelle's.
};
[[nodiscard]] const char* to_text(Fate fate);

struct Note {
  Fate fate = Fate::Kept;
  std::string where;  ///< "ekf.yaml:12"
  std::string node, key, text;
  /// Returns "translated: cam.yaml:12: usb_cam.framerate: camera.time_per_frame: [1, 30]".
  [[nodiscard]] std::string line() const;
};

/// A parameter of the file to write. A doubted one is written as a comment.
struct Line {
  std::string name;
  ParameterValue value;
  std::string doubt;
};
struct NodeSection {
  std::string name;    ///< "ekf", "/robot1/ekf"
  std::string source;  ///< Place of its section; "base" for a node that several sections describe.
  std::vector<Line> lines;
};

/// The result for several ROS 2 parameter files. Every parameter of every file has at least one note.
struct Imported {
  std::vector<NodeSection> nodes;
  std::vector<Note> notes;
  /// Returns Nacelle's parameter file, which reads back as these values.
  [[nodiscard]] std::string yaml() const;
};

/// Translates the sections of a parameter file written for diff_drive_controller and ros2_control, twist_mux,
/// robot_localization, teleop_twist_joy, v4l2_camera, usb_cam or an LD06 driver. The name and the parameters of a
/// section determine its driver (driver_of()).
/// Errors: text that is not a parameter file, and a file without any known driver, with file:line. Never throws. Pure.
[[nodiscard]] Result<void, std::vector<Problem>> import_file(std::string_view text, const std::string& file_name,
                                                             Imported& into);

/// Errors: `output` is one of the inputs, also under another name; with the way out.
[[nodiscard]] Result<void, Problem> may_write(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace nacelle::ros_import
