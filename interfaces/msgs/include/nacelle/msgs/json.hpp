// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/message_fault.hpp"
#include "nacelle/msgs/message_type.hpp"

#include <string>
#include <string_view>

// A message as one JSON object, for people and tests.
//
//   numbers, bool   JSON numbers (64-bit integers exact), true/false; a byte is a number, bytes an array of them
//   NaN, infinite   the strings "NaN", "Infinity", "-Infinity"
//   string, wstring JSON strings
//   arrays          JSON arrays
//   messages        JSON objects with the definition's field names, in its order; an empty message is {}
namespace nacelle::msgs {

/// Compact text, one line. Bytes of a string that are no UTF-8 appear as U+FFFD. Floats are written as the double that
/// they are, so that reading them gives the same value.
[[nodiscard]] std::string to_json(const MessageType& type, const void* message);

/// Sets every field of `message`: from the text, or to the definition's default where the text has none.
///
/// Errors: a MessageFault whose `where` is the path of the value ("transforms[2].header.stamp"), or the type. The message stays as
///         it was.
[[nodiscard]] Result<void, Problem> from_json(std::string_view text, const MessageType& type, void* message);

template <typename Message>
[[nodiscard]] std::string to_json(const Message& message) {
  return to_json(Message::message_type(), &message);
}

}  // namespace nacelle::msgs
