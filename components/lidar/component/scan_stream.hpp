// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <string>

#include "lidar/component/lidar_options.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/arrival_filter.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/node/device_watch.hpp"
#include "sensor_msgs/msg/laser_scan.hpp"

namespace nacelle::lidar {

/// What the reading thread counted and learnt.
struct LidarCounters {
  LineStats line{};
  ScanAssembler::Stats turns{};
  std::uint64_t published{};
};

/// From bytes to published scans, and from what is wanted to commands, on the reading thread.
///
/// Time of a beam: a packet is sent when its last beam was measured (or Sweep::age later), so that moment is the receive time of the
/// packet's last byte minus its byte times; an ArrivalFilter over the device's own time removes the thread's delays.
/// Allocates: nothing once the device is identified and the publisher's messages have their size.
class ScanStream final : public io::ByteSink, private SweepSink {
 public:
  ScanStream(const LidarOptions& options, const Clock& clock, io::ByteStream& line,
             std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher, const Logger& logger,
             DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override;
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  void on_return(MonotonicTime now) override;

  /// Begins to speak to the device; while no other thread reads.
  void begin() { converse(clock_.now()); }
  /// Stops a commanded device and its motor; while no other thread reads.
  void stop_device();
  /// Scans leave, and a commanded device measures, only while it is set. A read that is interrupted does it at once. Threads: any.
  void set_active(bool active);
  /// Waits, by an event, until the device does what is wanted (LidarProtocol::is_settled) or cannot. Threads: any other than the
  /// reading one.
  [[nodiscard]] bool wait_until_settled(Duration limit);
  /// Why the device cannot be used; empty if nothing is known to be wrong. Threads: any.
  [[nodiscard]] std::string refusal() const;
  /// Who the device says it is; may be empty. Threads: any.
  [[nodiscard]] std::string identity() const;
  [[nodiscard]] bool is_commanded() const { return protocol_->is_commanded(); }
  /// Threads: any.
  [[nodiscard]] LidarCounters counters() const;

 private:
  void on_sweep(const Sweep& sweep, std::size_t bytes_after) override;
  void converse(MonotonicTime now);
  void report();
  void publish(const Scan& scan);
  void watch_silence(MonotonicTime now);

  const LidarOptions options_;
  const Clock& clock_;
  const Duration byte_time_;
  io::ByteStream& line_;
  std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher_;
  const Logger& logger_;
  DeviceWatch& watch_;

  std::unique_ptr<LidarProtocol> protocol_;
  io::ArrivalFilter arrival_;
  ScanAssembler assembler_;
  MonotonicTime received_{};       ///< When the chunk came that is being read.
  MonotonicTime patient_until_{};  ///< A motor that was started needs time before the first frame.
  std::uint64_t published_ = 0;
  bool wanted_ = false;
  bool is_broken_ = false;  ///< The line is away.
  std::atomic<bool> active_{false};

  mutable Mutex mutex_;
  std::condition_variable settled_;
  LidarCounters counters_ NACELLE_GUARDED_BY(mutex_);
  bool is_settled_ NACELLE_GUARDED_BY(mutex_) = false;
  std::string refusal_ NACELLE_GUARDED_BY(mutex_), identity_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::lidar
