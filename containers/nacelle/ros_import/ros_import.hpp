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

/// What became of a key.
enum class Fate : std::uint8_t {
  Kept,        ///< Nacelle has it under the same name, with the same meaning.
  Translated,  ///< Another name, node or form; `text` says which.
  Dropped,     ///< Nothing in Nacelle needs it; `text` says why.
  Doubted,     ///< A person has to look: a slip of the pen, another meaning, nothing that does it.
  Added        ///< Not in the file: ROS's default, where Nacelle's is another.
};
[[nodiscard]] const char* to_text(Fate fate);

struct Note {
  Fate fate = Fate::Kept;
  std::string where;  ///< "ekf.yaml:12"
  std::string node, key, text;
  /// "translated: ekf.yaml:12: framerate: time_per_frame: [1, 30]"
  [[nodiscard]] std::string line() const;
};

/// A parameter of the file to be written; a doubted one stands there as a comment.
struct Line {
  std::string name;
  ParameterValue value;
  std::string doubt;
};
struct NodeSection {
  std::string name;    ///< "ekf", "/robot1/ekf"
  std::string source;  ///< Whom it is made of: the driver, and the section where there may be several.
  std::vector<Line> lines;
};

/// What several ROS 2 parameter files become. Every key of every file has at least one note.
struct Imported {
  std::vector<NodeSection> nodes;
  std::vector<Note> notes;
  /// Nacelle's parameter file; it reads back as these values.
  [[nodiscard]] std::string yaml() const;
};

/// Translates the sections of a parameter file written for diff_drive_controller and ros2_control, twist_mux, robot_localization,
/// teleop_twist_joy, v4l2_camera, usb_cam or an LD06 driver. Its name and its keys tell which one a section is for (driver_of()).
/// Errors: what is no parameter file, and a file without any known driver, with file:line. Never throws. Pure.
[[nodiscard]] Result<void, std::vector<Problem>> import_file(std::string_view text, const std::string& file_name,
                                                             Imported& into);

/// The way out if the result would be written over a file that it is made of; the same file under another name, too.
[[nodiscard]] Result<void, Problem> may_write(const std::string& output, const std::vector<std::string>& inputs);

}  // namespace nacelle::ros_import
