// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::text {

/// A message in the form typed for `ros2 topic pub` and `ros2 service call`.
struct MessageText {
  std::string json;         ///< What msgs::from_json() reads.
  bool has_stamps = false;  ///< It contains the time of parsing: parse it again for each message.
};

/// Parses YAML ("{linear: {x: 0.1}}"; JSON is accepted too). The field's type decides about a scalar: 5 is a number in
/// a float64 and a text in a string. `auto` for a std_msgs/Header and `now` for a builtin_interfaces/Time stand for the
/// argument `now`. An empty text is a message of defaults.
/// Errors: a msgs::MessageFault whose `where` is the line or the path of the value. from_json() checks whether values
/// fit their fields.
/// Source: rosidl_runtime_py, set_message.py (jazzy).
[[nodiscard]] Result<MessageText, Problem> read_message_text(std::string_view text, const msgs::MessageType& type,
                                                             WallTime now);

/// Appends a message in Python's form: "std_srvs.srv.SetBool_Response(success=True, message='')".
/// Source: rosidl_generator_py, _msg.py.em (jazzy), __repr__.
void append_repr(std::string& out, const msgs::MessageType& type, const void* message);

}  // namespace nacelle::text
