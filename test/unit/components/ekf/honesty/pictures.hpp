// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nees.hpp"

namespace nacelle::ekf::honesty {

/// Writes into a folder: track.svg (estimate and truth), and position_error.svg (across the track) and yaw_error.svg, the error of the
/// motion over 10 s with its 95 % band.
/// Returns false if a file cannot be written; the reason is on stderr.
[[nodiscard]] bool draw(const std::string& folder, const Drive& drive, const Setup& setup);

}  // namespace nacelle::ekf::honesty
