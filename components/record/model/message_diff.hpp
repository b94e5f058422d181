// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/msgs/message_type.hpp"
#include "record/model/tolerances.hpp"

namespace nacelle::record {

/// Two values that differ by more than is allowed.
struct ValueDifference {
  std::string path;  ///< "ranges[3]"
  std::string a, b;  ///< Numbers and texts, or "3 elements".
};

/// All differences of a field, over many messages.
struct FieldDifference {
  std::uint64_t values = 0;  ///< That differ by more than is allowed.
  bool is_number = false;
  double largest = 0.0;   ///< Of a number; infinity if one of two values is infinite or none at all. Of times in s.
  std::string path;       ///< Where the largest is, or the first.
  std::size_t round = 0;  ///< In which call of compare(), counted from 0.
};

/// Compares messages of one type, field by field. NaN is equal to NaN; a list that has another length is one difference.
///
/// The type and the tolerances must outlive this object. Threads: one.
class MessageDiff {
 public:
  MessageDiff(const msgs::MessageType& type, ToleranceScope allowed) : type_(type), allowed_(std::move(allowed)) {}

  /// Returns the first difference in the definition's order; nothing if there is none.
  [[nodiscard]] std::optional<ValueDifference> compare(const void* a, const void* b);
  /// Counts a pair that was found equal in another way as one call.
  void skip() { ++round_; }
  [[nodiscard]] const msgs::MessageType& type() const { return type_; }
  /// The differences of all calls so far, by the path with "[*]" for each index.
  [[nodiscard]] const std::map<std::string, FieldDifference>& fields() const { return fields_; }

 private:
  void look_at_message(const msgs::MessageType& type, const void* a, const void* b, const ToleranceScope& scope);
  void look_at_field(const msgs::Field& field, const void* a, const void* b, const ToleranceScope& scope);
  void look_at_value(const msgs::Field& field, const void* a, const void* b, const ToleranceScope& scope);
  /// Goes to an element, and back at the end of the block.
  class ElementPath;
  void note(std::string a, std::string b, const double* difference);

  const msgs::MessageType& type_;
  const ToleranceScope allowed_;
  std::string path_, pattern_;  // of the field at hand
  std::optional<ValueDifference> first_;
  std::map<std::string, FieldDifference> fields_;
  std::size_t round_ = 0;
};

}  // namespace nacelle::record
