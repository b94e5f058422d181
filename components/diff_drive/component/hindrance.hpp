// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <string>

#include "diff_drive/component/drive_loop.hpp"

namespace nacelle::diff_drive {

/// Why the base does not follow its commands; an empty text if it does.
struct Hindrance {
  std::string text;
  std::uint8_t level = diagnostic_msgs::msg::DiagnosticStatus::OK;
};

/// Returns the worst of those that the loop sees. `board_fault` is what the board reports, or null.
[[nodiscard]] Hindrance hindrance_of(const DriveLoop::Look& look, const char* board_fault);

}  // namespace nacelle::diff_drive
