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

/// A field of the messages of a type, by its path: "header.stamp", "pose.pose.position.x". The field may be a list; a
/// path cannot lead through a list.
///
/// The type must outlive this object. Threads: constant.
class MessageField {
 public:
  /// Errors: an unknown name, with the known ones; a path through a list or through a plain value.
  [[nodiscard]] static Result<MessageField, Problem> find(const msgs::MessageType& type, std::string_view path);

  /// Appends the field as `ros2 topic echo --field` prints it: a text unquoted, any other value in YAML, with a line
  /// end.
  void append_yaml(std::string& out, const void* message, const YamlOptions& options) const;
  /// Returns the field as JSON.
  [[nodiscard]] std::string to_json(const void* message) const;

 private:
  MessageField(const msgs::MessageType& owner, const msgs::Field& field, std::size_t offset);

  /// The type of the message that contains the field, reduced to this field, and the offset of that message.
  msgs::MessageType only_;
  std::size_t offset_;
};

}  // namespace nacelle::text
