// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <string>

#include "lidar/component/lidar_options.hpp"
#include "lidar/protocol/ld06_decoder.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/arrival_filter.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/node/device_watch.hpp"
#include "sensor_msgs/msg/laser_scan.hpp"

namespace nacelle::lidar {

/// What the reading thread counted.
struct LidarCounters {
  Ld06Decoder::Stats line{};
  ScanAssembler::Stats turns{};
  std::uint64_t published{};
};

/// From bytes to published scans, on the reading thread.
///
/// Time of a point: a frame is sent when its last point was measured, so that moment is the receive time of the
/// frame's last byte minus 47 byte times; an ArrivalFilter removes the thread's delays.
/// Allocates: nothing once the publisher's messages have their size.
class ScanStream final : public io::ByteSink {
 public:
  ScanStream(const LidarOptions& options, const Clock& clock,
             std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher, const Logger& logger,
             DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override;
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  void on_return(MonotonicTime now) override;

  /// Scans leave only while it is set. Threads: any.
  void set_active(bool active) { active_.store(active, std::memory_order_relaxed); }
  /// Waits, by an event, for the first frame. Threads: any other than the reading one.
  [[nodiscard]] bool wait_for_frame(Duration limit);
  /// Threads: any.
  [[nodiscard]] LidarCounters counters() const;

 private:
  void publish(const Scan& scan);
  void watch_silence(MonotonicTime now);

  const LidarOptions options_;
  const Clock& clock_;
  const Duration byte_time_;
  std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher_;
  const Logger& logger_;
  DeviceWatch& watch_;

  Ld06Decoder decoder_;
  io::ArrivalFilter arrival_;
  ScanAssembler assembler_;
  double last_angle_cdeg_ = -1.0;
  std::uint64_t published_ = 0;
  std::atomic<bool> active_{false};

  mutable Mutex mutex_;
  std::condition_variable frame_came_;
  LidarCounters counters_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::lidar
