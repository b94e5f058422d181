// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "text/message_yaml.hpp"

namespace nacelle::text {

/// One part of the messages of a type: "header.stamp", "pose.pose.position.x". A part may be a list; none leads through one.
/// The type outlives it. Threads: constant.
class MessageField {
 public:
  /// Errors: a name that is no field, with those that are; a way through a list or through a plain value.
  [[nodiscard]] static Result<MessageField, Problem> find(const msgs::MessageType& type, std::string_view path);

  /// The part alone, as `ros2 topic echo --field` prints it: a text as it is, all else in YAML, with a line's end.
  void append_yaml(std::string& out, const void* message, const YamlOptions& options) const;
  /// The part alone as JSON.
  [[nodiscard]] std::string to_json(const void* message) const;

 private:
  MessageField(const msgs::MessageType& owner, const msgs::Field& field, std::size_t offset);

  /// The message that the part belongs to, as if it had this field only; and where it lies in the whole.
  msgs::MessageType only_;
  std::size_t offset_;
};

}  // namespace nacelle::text
