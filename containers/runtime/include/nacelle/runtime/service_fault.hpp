// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::runtime {

/// Why a call of a service has no answer.
enum class ServiceFault : std::uint8_t {
  NoAnswer,    ///< The server has not answered within the caller's limit.
  ServerGone,  ///< The server's node was destroyed before it answered.
};
[[nodiscard]] constexpr const char* code_text(ServiceFault fault) {
  return fault == ServiceFault::NoAnswer ? "service.no_answer" : "service.server_gone";
}

}  // namespace nacelle::runtime
