// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::record {

/// One step of a field's path: a name, or an element of the list that the steps before it lead to.
struct PathStep {
  enum class Kind : std::uint8_t { Field, Element, EveryElement };

  Kind kind = Kind::Field;
  std::string name;       ///< Of a Field.
  std::size_t index = 0;  ///< Of an Element.
  friend bool operator==(const PathStep&, const PathStep&) = default;
};

/// Parses "pose.covariance[35]", "points[*].x".
/// Errors: an empty name, a bracket without its partner, an index that is no number; `where` names the path.
[[nodiscard]] Result<std::vector<PathStep>, Problem> parse_field_path(std::string_view text);

/// Returns whether messages of this type are times (builtin_interfaces/msg/Time and Duration). Here they are one number, in seconds.
[[nodiscard]] bool is_time(const msgs::MessageType& type);
/// Returns a time, or a duration, in ns.
[[nodiscard]] std::int64_t nanoseconds_of(const msgs::MessageType& type, const void* time);

/// Checks that the path leads to a field of this type, or to an element of a list.
/// Errors: an unknown name, with the nearest one and those that there are; a path through a plain value, an index of what is no list, an
/// index beyond the end of an array; `where` names the path.
[[nodiscard]] Result<void, Problem> check_field_path(const msgs::MessageType& type, std::string_view text);

/// A numeric field of the messages of a type, by its path: "pose.pose.position.x", "ranges[3]". A time is a number, in seconds.
///
/// The type must outlive this object. Threads: constant.
class NumericField {
 public:
  /// Errors: those of check_field_path(); a path to a list, a text or a message, or with "[*]".
  [[nodiscard]] static Result<NumericField, Problem> find(const msgs::MessageType& type, std::string_view text);

  /// Returns the value; nothing if a list has no such element. A bool is 0 or 1.
  [[nodiscard]] std::optional<double> read(const void* message) const;

 private:
  struct Part {
    const msgs::Field* field = nullptr;
    std::size_t index = 0;  // 0 for a single value
  };
  std::vector<Part> parts_;
};

}  // namespace nacelle::record
