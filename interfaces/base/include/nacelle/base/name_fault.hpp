// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle {

/// What is wrong with a name of a container, component, node, topic, service, frame or parameter. Problem::value is the name.
enum class NameFault : std::uint8_t {
  Invalid,    ///< It has characters, or a form, that no name may have.
  Unknown,    ///< There is nothing of that name.
  Ambiguous,  ///< There are several things of that name; the full name says which.
  Taken,      ///< Something else has it.
  OtherType,  ///< What has the name is of another type.
};
[[nodiscard]] constexpr const char* code_text(NameFault fault) {
  switch (fault) {
    case NameFault::Invalid: return "name.invalid";
    case NameFault::Unknown: return "name.unknown";
    case NameFault::Ambiguous: return "name.ambiguous";
    case NameFault::Taken: return "name.taken";
    case NameFault::OtherType: return "name.other_type";
  }
  return "";
}

}  // namespace nacelle
