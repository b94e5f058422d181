// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_device.hpp"

#include <fmt/format.h>

#include <thread>

#include "imu/component/bno055_line.hpp"
#include "imu/model/rvc_reader.hpp"
#include "imu/model/wt901_reader.hpp"
#include "nacelle/io/i2c_bus.hpp"
#include "nacelle/io/serial_port.hpp"

namespace nacelle::imu {
namespace {

Result<std::unique_ptr<io::ByteStream>, Problem> open_serial(const ImuOptions& options, const Clock& clock) {
  const io::SerialSettings settings{options.port, options.baudrate};
  auto port = options.device.required ? io::SerialPort::open(settings, clock, options.port_timeout)
                                      : io::SerialPort::open_or_await(settings, clock);
  if (!port) return err(std::move(port).error());
  return std::unique_ptr<io::ByteStream>{std::move(port).value()};
}

Result<std::unique_ptr<io::RegisterBus>, Problem> open_i2c(const ImuOptions& options, const Clock& clock) {
  const io::I2cSettings settings{options.port, options.address};
  auto bus = options.device.required ? io::I2cBus::open(settings, clock, options.port_timeout)
                                     : io::I2cBus::open_or_await(settings, clock);
  if (!bus) return err(std::move(bus).error());
  return std::unique_ptr<io::RegisterBus>{std::move(bus).value()};
}

Result<void, SetUpFault> set_up_wt901(const ImuOptions& options, io::ByteStream& line) {
  if (!options.configure_device) return {};
  // Not saved: the settings are given at every start, and the device's flash wears.
  for (const Wt901Command& command : {unlock_command(), mask_command(kOutputMask), *rate_command(options.rate_hz)}) {
    if (auto written = line.write(command); !written)
      return err(SetUpFault{written.error(), std::string(io::explain(written.error())), "is it connected?"});
    if (options.command_pause > Duration::zero()) std::this_thread::sleep_for(options.command_pause);
  }
  return {};
}

ImuDevice polled_device(const ImuOptions& options, const Clock& clock, std::unique_ptr<io::RegisterBus> bus) {
  ChipPlan plan = plan_chip(options);
  ImuDevice device;
  auto stream = std::make_unique<io::RegisterStream>(std::move(bus), std::move(plan.blocks), plan.poll_period, clock);
  device.polled = stream.get();
  device.line = std::move(stream);
  device.reader = std::make_unique<ChipReader>(std::move(plan.decoder), plan.units);
  device.set_up = [&clock, polled = device.polled, steps = std::move(plan.set_up)] {
    return set_up_chip(polled->bus(), steps, clock);
  };
  return device;
}

}  // namespace

ImuPorts ImuPorts::real() { return {open_serial, open_i2c}; }

Result<ImuDevice, Problem> open_imu(const ImuOptions& options, const Clock& clock, const ImuPorts& ports) {
  if (options.traits->is_on_i2c) {
    auto bus = ports.bus(options, clock);
    if (!bus) return err(bus.error());
    return polled_device(options, clock, std::move(bus).value());
  }
  auto line = ports.line(options, clock);
  if (!line) return err(line.error());
  if (options.model == ImuModel::Bno055Uart) {
    return polled_device(options, clock, std::make_unique<Bno055Line>(std::move(line).value(), clock));
  }
  ImuDevice device;
  device.line = std::move(line).value();
  const Duration byte_time = io::byte_time(options.baudrate);
  if (options.model == ImuModel::Wt901) {
    device.reader = std::make_unique<Wt901Reader>(kOutputMask, options.magnetic_field_scale, byte_time,
                                                  from_seconds(1.0 / options.rate_hz));
    device.set_up = [options, line = device.line.get()] { return set_up_wt901(options, *line); };
  } else {
    device.reader = std::make_unique<RvcReader>(byte_time);
    device.set_up = [] { return Result<void, SetUpFault>{}; };
  }
  return device;
}

}  // namespace nacelle::imu
