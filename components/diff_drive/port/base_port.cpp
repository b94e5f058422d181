// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/base_port.hpp"

namespace nacelle::diff_drive {

std::string_view explain(BaseFault fault) {
  switch (fault) {
    case BaseFault::LineLost: return "the line to the motor board is disconnected (cable pulled, board off?)";
    case BaseFault::LineStuck: return "the line to the motor board takes no bytes";
    case BaseFault::LineRefused: return "the kernel refused to read or write the line to the motor board";
    case BaseFault::NotSendable: return "a wheel rate that no command can carry";
  }
  return "unknown fault";
}

}  // namespace nacelle::diff_drive
