// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "nacelle/launch/parameter_file.hpp"

namespace nacelle::launch {

/// How the transforms of robots on one network are kept apart.
enum class TfApart : std::uint8_t {
  Topics,  ///< /tf and /tf_static are moved below the namespace, as Nav2 does; frames keep their names.
  Frames  ///< Both topics stay; every frame's name begins with the namespace, as robot_state_publisher's frame_prefix does.
};

/// Where all nodes of a launch file are put: `namespace:=NAME` on the command line, or the file's `namespace:`.
struct NamespacePlan {
  std::string path = "/";  ///< "/": nothing is moved.
  TfApart tf = TfApart::Topics;
  Place where;
  bool declared = false;  ///< The files have a `namespace:`.

  [[nodiscard]] bool moves() const { return path != "/"; }
  /// "/cmd_vel" from "cmd_vel"; with a namespace "/robot1/cmd_vel". An absolute name stays.
  [[nodiscard]] std::string topic(std::string_view name) const;
  /// "/tf", or where it was moved to.
  [[nodiscard]] std::string tf_topic() const { return moves() && tf == TfApart::Topics ? path + "/tf" : "/tf"; }
  /// "", or "robot1/": what stands before each frame's name.
  [[nodiscard]] std::string frame_prefix() const;
  /// The frame's name with it, by the rule of nacelle/node/frame_name.hpp.
  [[nodiscard]] std::string frame(const std::string& name) const;
};

[[nodiscard]] const char* to_text(TfApart tf);  ///< "topics", "frames"

}  // namespace nacelle::launch
