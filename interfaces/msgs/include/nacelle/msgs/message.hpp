// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every generated message header needs, and nothing more: each translation unit of a component reads this file.
#include "nacelle/base/buffer.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace nacelle::msgs {
struct MessageType;
struct ServiceType;
struct ActionType;
}  // namespace nacelle::msgs
