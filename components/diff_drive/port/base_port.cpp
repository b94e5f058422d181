// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/base_port.hpp"

namespace nacelle::diff_drive {

std::string_view explain(BaseFault fault) {
  switch (fault) {
    case BaseFault::LineLost: return "the line to the motor board is disconnected (cable pulled, board off?)";
    case BaseFault::LineStuck: return "the line to the motor board takes no bytes";
    case BaseFault::LineRefused: return "the kernel refused to read or write the line to the motor board";
    case BaseFault::LineDown:
      return "the CAN interface of the motor boards is down (`sudo ip link set can0 up type can bitrate 500000`)";
    case BaseFault::BusOff:
      return "the CAN controller is off the motor boards' bus (wiring, termination or bit rate; `sudo ip link set can0 "
             "type can restart`)";
    case BaseFault::OutputLost:
      return "the kernel takes no values for the motors' PWM or direction lines (driver unbound, chip unplugged?)";
    case BaseFault::EncodersLost: return "the wheels' encoders cannot be read (driver unbound, chip unplugged?)";
    case BaseFault::NotSendable: return "a wheel rate that no command can carry";
  }
  return "unknown fault";
}

}  // namespace nacelle::diff_drive
