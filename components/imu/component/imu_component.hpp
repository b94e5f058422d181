// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "imu/component/imu_stream.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::imu {

/// A WitMotion WT901 on a serial line (node name "imu"), published as REP 145 says:
/// imu/data_raw without orientation, imu/data with it (ENU), imu/mag in tesla; the three messages of one sample share
/// a stamp.
///
/// configure opens the line, sets the device up and waits for a sample; activate waits until the gyro's bias is
/// known, for which the robot must stand still; the thread "imu_rx" publishes. The bias is taken off both imu topics.
/// A device that returns is set up again; one that was absent at activation is calibrated before its samples are published.
/// Errors: an open fault DEVICE_LOST while the device is absent or silent (0.5 s or three periods); with device_lost: fault the
/// fault IMU_SILENT when no sample came for silence_limit.
class ImuComponent final : public LifecycleNode {
 public:
  /// Opens the line; tests give a scripted one.
  using OpenLine =
      std::function<Result<std::unique_ptr<io::ByteStream>, Problem>(const ImuOptions& options, const Clock& clock)>;

  explicit ImuComponent(const NodeOptions& options);
  ImuComponent(const NodeOptions& options, OpenLine open_line);
  ~ImuComponent() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State&) override;
  CallbackReturn on_error(const State&) override;

  Result<void, io::StreamFault> set_up_device();
  Result<void, Problem> calibrate();
  void close();
  void log_counters() const;

  OpenLine open_line_;
  ImuPublishers publishers_;
  ImuOptions options_;
  bool calibrated_ = false;
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<io::ByteStream> line_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<ImuStream> stream_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::imu
