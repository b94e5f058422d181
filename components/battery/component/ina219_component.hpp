// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "battery/component/ina219_publisher.hpp"
#include "nacelle/io/register_stream.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::battery {

/// An INA219 between a battery and its load, published as sensor_msgs/BatteryState on `battery_state` (node name "battery"): voltage at the
/// battery, current (negative while it discharges), and, with empty_voltage and full_voltage, a rough percentage. What is not known is NaN.
///
/// configure opens the bus and looks for the chip, if they are there; while the node is active the thread "battery" reads it at `rate`. deactivate
/// powers the chip down.
/// Errors: an open fault DEVICE_LOST while the bus or the chip is absent (0.5 s or three periods); with device_lost: fault the fault
/// BATTERY_SILENT after silence_limit.
class Ina219Component final : public LifecycleNode {
 public:
  /// Opens a bus, a missing one too unless the device is required.
  using OpenBus = std::function<Result<std::unique_ptr<io::RegisterBus>, Problem>(const Ina219Options&, const Clock&)>;

  explicit Ina219Component(const NodeOptions& options);
  /// With another bus.
  Ina219Component(const NodeOptions& options, OpenBus open_bus);
  ~Ina219Component() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State& state) override { return on_cleanup(state); }
  CallbackReturn on_error(const State& state) override { return on_cleanup(state); }

  void declare_parameters();
  [[nodiscard]] Result<Ina219Options, Problem> read_options() const;
  [[nodiscard]] Ina219 chip() { return {stream_->bus(), options_.address, options_.setup}; }
  [[nodiscard]] std::string title() const;
  void close();

  const OpenBus open_bus_;
  std::shared_ptr<Publisher<sensor_msgs::msg::BatteryState>> publisher_;
  Ina219Options options_;
  std::string absence_;  // why the chip is not there, as configure found it
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<io::RegisterStream> stream_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<Ina219Publisher> sink_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::battery
