// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "imu/component/chip_setup.hpp"
#include "imu/component/imu_options.hpp"
#include "imu/model/device_reader.hpp"
#include "nacelle/io/register_bus.hpp"
#include "nacelle/io/register_stream.hpp"

namespace nacelle::imu {

/// Opens what the device is connected to; tests give scripted ones. An absent port is no error unless the device is required.
struct ImuPorts {
  std::function<Result<std::unique_ptr<io::ByteStream>, Problem>(const ImuOptions& options, const Clock& clock)> line;
  std::function<Result<std::unique_ptr<io::RegisterBus>, Problem>(const ImuOptions& options, const Clock& clock)> bus;

  /// The kernel's serial lines and I2C buses.
  [[nodiscard]] static ImuPorts real();
};

/// One IMU: where its bytes come from, what they mean, and how it is set up.
struct ImuDevice {
  std::unique_ptr<io::ByteStream> line;
  std::unique_ptr<DeviceReader> reader;
  /// On the reading thread, or while there is none. Takes up to a second.
  std::function<Result<void, SetUpFault>()> set_up;
  /// The same as `line` if that is a polled chip, else null.
  io::RegisterStream* polled = nullptr;
};

/// Opens the device of these options; sets nothing up. Errors: a Problem that names the port and the way out.
[[nodiscard]] Result<ImuDevice, Problem> open_imu(const ImuOptions& options, const Clock& clock, const ImuPorts& ports);

}  // namespace nacelle::imu
