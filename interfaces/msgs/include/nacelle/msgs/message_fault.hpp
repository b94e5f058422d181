// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::msgs {

/// Why a text is not a message of a type. Problem::where is the path of the field, Problem::value what stands there.
enum class MessageFault : std::uint8_t {
  Malformed,     ///< The text is neither JSON nor YAML, or is nested too deeply.
  UnknownField,  ///< The type has no such field; Problem::value is its name.
  Twice,         ///< A field is given twice; Problem::value is its name.
  WrongType,     ///< The value is of another type than the field: a text for a number, a number for a list.
  OutOfRange,    ///< The number does not fit the field's type.
  WrongLength,   ///< The list or the text has more elements than its bound, or another number than the array.
};
[[nodiscard]] constexpr const char* code_text(MessageFault fault) {
  switch (fault) {
    case MessageFault::Malformed: return "message.malformed";
    case MessageFault::UnknownField: return "message.unknown_field";
    case MessageFault::Twice: return "message.field_twice";
    case MessageFault::WrongType: return "message.wrong_type";
    case MessageFault::OutOfRange: return "message.out_of_range";
    case MessageFault::WrongLength: return "message.wrong_length";
  }
  return "";
}

}  // namespace nacelle::msgs
