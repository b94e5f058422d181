// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "doctor/machine.hpp"

namespace nacelle::doctor {

/// A device that is plugged in.
struct PluggedIn {
  std::string kind;  ///< "serial", "camera", "gamepad", "I2C", "CAN"
  std::string
      path;  ///< What to write into a launch file: a name that stays the same however it is plugged in, if there is one.
  std::string node;    ///< "/dev/ttyUSB0", or the interface of a CAN bus.
  std::string name;    ///< As the device or its driver says: "CP2102 USB to UART Bridge Controller".
  std::string usb;     ///< Vendor and product: "10c4:ea60". Empty: not on USB.
  std::string serial;  ///< The USB serial number; may be empty.
  std::string guess;   ///< What it may be, by its USB numbers; may be empty.
  std::vector<Process> held_by;
};

/// Returns what is plugged in, by kind and then by path. Opens no device.
[[nodiscard]] std::vector<PluggedIn> plugged_in(const Machine& machine);

/// A component that drives a device, in words of a launch file.
struct Driver {
  std::string plugin;     ///< "nacelle::lidar::LidarComponent"
  std::string parameter;  ///< "port_name"
  std::string setting;    ///< A further entry of `param` as YAML, or empty.
};

/// Returns the line of a launch file that loads this driver for `device`: the value of its parameter, a path or a gamepad's name.
[[nodiscard]] std::string launch_line(const Driver& driver, const std::string& device);

}  // namespace nacelle::doctor
