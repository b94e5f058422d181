// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/node/node.hpp"

namespace nacelle {

/// robot_state_publisher's parameter, here of each node that names frames: what stands before their names, "" or "robot1/".
/// A launch in a namespace with tf:=frames gives it to all its nodes.
inline constexpr const char* kFramePrefixParameter = "frame_prefix";

/// Returns `frame` with the prefix; no slash is added. A name that begins with the prefix, and an empty one, stay as they are. A
/// name that begins with '/' is global: it loses the slash and gets no prefix ("/map").
[[nodiscard]] inline std::string with_frame_prefix(const std::string& prefix, const std::string& frame) {
  if (prefix.empty() || frame.starts_with(prefix)) return frame;
  if (frame.starts_with('/')) return frame.substr(1);
  return frame.empty() ? frame : prefix + frame;
}

/// For a constructor, before frame_name(). Errors: as declare_parameter().
inline void declare_frame_prefix(Node& node) {
  node.declare_parameter(kFramePrefixParameter, "",
                         {.description = "Written before every frame's name; no slash is added.", .read_only = true});
}

/// The frame that a text parameter names, as it stands in messages. Errors: as Node::get().
[[nodiscard]] inline std::string frame_name(const Node& node, const std::string& parameter) {
  return with_frame_prefix(node.get<std::string>(kFramePrefixParameter), node.get<std::string>(parameter));
}

}  // namespace nacelle
