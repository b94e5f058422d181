// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::text {

struct YamlOptions {
  /// Sequences, arrays and texts longer than this end with '...'; 0: no limit. The default is that of ros2 topic echo.
  std::size_t longest = 128;
};

/// Appends a message in the form of `ros2 topic echo`, without the "---" that follows it.
/// Source: rosidl_runtime_py, convert.py (message_to_yaml).
void append_yaml(std::string& out, const msgs::MessageType& type, const void* message, const YamlOptions& options);

}  // namespace nacelle::text
