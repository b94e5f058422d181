// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/node/lifecycle_node.hpp"
#include "range/component/vl53l0x_publisher.hpp"
#include "range/component/vl53l0x_stream.hpp"

namespace nacelle::range {

/// A VL53L0X on an I2C bus, published as sensor_msgs/Range on `range` (node name "range"): +Inf if nothing is in range, -Inf if something is
/// nearer than min_range, NaN if the measurement means nothing (REP 117). Stamp: when the measurement began.
///
/// configure opens the bus and sets the sensor up, if they are there; while the node is active the sensor measures by its own clock, and the
/// thread "range" reads it. deactivate stops the laser.
/// Errors: an open fault DEVICE_LOST while the bus or the sensor is absent, or does not measure (0.5 s or three periods); with
/// device_lost: fault the fault RANGE_SILENT after silence_limit.
class Vl53l0xComponent final : public LifecycleNode {
 public:
  /// Opens a bus, a missing one too unless the device is required.
  using OpenBus = std::function<Result<std::unique_ptr<io::RegisterBus>, Problem>(const Vl53l0xOptions&, const Clock&)>;

  explicit Vl53l0xComponent(const NodeOptions& options);
  /// With another bus.
  Vl53l0xComponent(const NodeOptions& options, OpenBus open_bus);
  ~Vl53l0xComponent() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State& state) override { return on_cleanup(state); }
  CallbackReturn on_error(const State& state) override { return on_cleanup(state); }

  void declare_parameters();
  [[nodiscard]] Result<Vl53l0xOptions, Problem> read_options() const;
  [[nodiscard]] std::string title() const;
  void close();

  const OpenBus open_bus_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher_;
  Vl53l0xOptions options_;
  std::string absence_;  // why the sensor is not there, as configure found it
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<Vl53l0xStream> stream_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<Vl53l0xPublisher> sink_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::range
