// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "imu/component/imu_device.hpp"
#include "imu/component/imu_stream.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::imu {

/// An IMU on a serial line or on I2C (node name "imu"; parameter `model`), published as REP 145 says: imu/data_raw without
/// orientation, imu/data with it (ENU) if the device computes it and publish_orientation is set, imu/mag in tesla, imu/temperature once a
/// second. The messages of one sample share a stamp.
///
/// configure opens the port, sets the device up and waits for a sample; activate waits until the gyro's bias is
/// known, for which the robot must stand still; the thread "imu_rx" publishes. The bias is taken off both imu topics, after the
/// corrections of the parameters and the mounting.
/// A device that returns is set up again; one that was absent at activation is calibrated before its samples are published.
/// Errors: an open fault DEVICE_LOST while the device is absent or silent (0.5 s or three periods); with device_lost: fault the
/// fault IMU_SILENT when no sample came for silence_limit.
class ImuComponent final : public LifecycleNode {
 public:
  explicit ImuComponent(const NodeOptions& options);
  /// Tests give scripted ports.
  ImuComponent(const NodeOptions& options, ImuPorts ports);
  ~ImuComponent() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State&) override;
  CallbackReturn on_error(const State&) override;

  /// Sets the device up. Returns false, and keeps the problem, if the component cannot be configured.
  bool set_up_at_start(Problem& problem);
  Result<void, Problem> calibrate();
  void close();
  void log_counters() const;

  const ImuPorts ports_;
  ImuPublishers publishers_;
  ImuOptions options_;
  bool calibrated_ = false;
  // In this order: the thread ends before the objects that it uses.
  ImuDevice device_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<ImuStream> stream_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::imu
