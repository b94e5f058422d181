// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/io/line_signature.hpp"

namespace nacelle::doctor {

/// What came over a serial line while somebody listened.
struct HeardDevice {
  const io::SerialDevice* device = nullptr;  ///< Null: not recognised.
  unsigned baud = 0;                         ///< At which it was recognised.
  std::size_t bytes = 0;                     ///< At all baud rates.
};

/// Listens to a serial line at each baud rate of the known devices, and writes nothing. Opening a line sets its modem lines, which restarts
/// some boards.
/// Errors: a Problem if the line cannot be opened. Blocks: for `at_each` and baud rate at the longest.
[[nodiscard]] Result<HeardDevice, Problem> listen(const std::string& path, const Clock& clock, Duration at_each);

}  // namespace nacelle::doctor
