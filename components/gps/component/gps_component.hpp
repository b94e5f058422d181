// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "gps/component/gps_stream.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::gps {

/// A GPS receiver on a serial line that speaks NMEA 0183 (node name "gps"): `fix` (sensor_msgs/NavSatFix, height above the ellipsoid),
/// `vel` (geometry_msgs/TwistStamped, east and north), `time_reference` (sensor_msgs/TimeReference), as nmea_navsat_driver's.
///
/// A receiver without a fix publishes STATUS_NO_FIX with NaN for the position. Height is NaN without the geoid's height in the sentence.
/// configure opens the line, if it is there, and waits for a sentence; the thread "gps_rx" publishes.
/// Errors: an open fault DEVICE_LOST while the device is absent, or silent for three of its periods (0.5 s at the least, 3 s before it
/// sent twice); with device_lost: fault the fault GPS_SILENT when no sentence came for silence_limit. No fix is no fault.
class GpsComponent final : public LifecycleNode {
 public:
  /// Opens the line; tests give a scripted one.
  using OpenLine =
      std::function<Result<std::unique_ptr<io::ByteStream>, Problem>(const GpsOptions& options, const Clock& clock)>;

  explicit GpsComponent(const NodeOptions& options);
  GpsComponent(const NodeOptions& options, OpenLine open_line);
  ~GpsComponent() override;

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
  GpsPublishers publishers_;
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<io::ByteStream> line_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<GpsStream> stream_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::gps
