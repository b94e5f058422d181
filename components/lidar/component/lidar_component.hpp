// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "lidar/component/scan_stream.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::lidar {

/// A LiDAR on a serial line, published as sensor_msgs/LaserScan (default topic "scan", node name "lidar"). The parameter `model`
/// says which.
///
/// Every scan is one full turn of `scan_points` rays: angle_min 0 (the device's front mark, the x axis of frame_id),
/// angle_increment 2 * pi / scan_points, counter-clockwise. Stamp: when the turn's first beam (ray 0) was measured. The
/// device turns clockwise, so ray i was measured at stamp + ((scan_points - i) mod scan_points) * time_increment.
/// configure opens the line, if it is there, and waits for a frame, or for the answers of a commanded device; activate starts that
/// device and lets scans out; the thread "lidar_rx" publishes them; deactivate stops stream and motor where the device can be told.
/// Errors: an open fault DEVICE_LOST while the device is absent or silent (0.5 s); with device_lost: fault the fault LIDAR_SILENT
/// when no frame came for silence_limit.
class LidarComponent final : public LifecycleNode {
 public:
  /// Opens the line; tests give a scripted one.
  using OpenLine =
      std::function<Result<std::unique_ptr<io::ByteStream>, Problem>(const LidarOptions& options, const Clock& clock)>;

  explicit LidarComponent(const NodeOptions& options);
  LidarComponent(const NodeOptions& options, OpenLine open_line);
  ~LidarComponent() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State&) override;
  CallbackReturn on_error(const State&) override;

  void close();
  void log_counters() const;

  OpenLine open_line_;
  std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher_;
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<io::ByteStream> line_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<ScanStream> stream_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::lidar
