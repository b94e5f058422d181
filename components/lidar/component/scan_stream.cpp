// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/scan_stream.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "nacelle/io/serial_port.hpp"

namespace nacelle::lidar {

ScanStream::ScanStream(const LidarOptions& options, const Clock& clock,
                       std::shared_ptr<Publisher<sensor_msgs::msg::LaserScan>> publisher, const Logger& logger,
                       DeviceWatch& watch)
    : options_(options),
      clock_(clock),
      byte_time_(io::byte_time(options.port_baudrate)),
      publisher_(std::move(publisher)),
      logger_(logger),
      watch_(watch),
      assembler_(options.scan) {}

void ScanStream::on_bytes(ByteView bytes, MonotonicTime received) {
  decoder_.feed(bytes, [&](const Ld06Frame& frame, std::size_t bytes_after) {
    const auto on_line = static_cast<std::int64_t>(bytes_after + ld06_layout::kFrameBytes);
    // The device's own time since the frame before: how far it turned, at the speed it says.
    const double turned_cdeg =
        last_angle_cdeg_ < 0.0 ? 0.0 : std::fmod(frame.last_angle_cdeg + 36000.0 - last_angle_cdeg_, 36000.0);
    last_angle_cdeg_ = frame.last_angle_cdeg;
    const Duration step = frame.speed_dps == 0 ? Duration{} : from_seconds(turned_cdeg / 100.0 / frame.speed_dps);
    const MonotonicTime last_point = arrival_.settle(received, byte_time_ * on_line, step);
    assembler_.add(frame, last_point, [this](const Scan& scan) { publish(scan); });
    watch_.heard(received);
  });
  {
    const LockGuard lock{mutex_};
    const bool first = counters_.line.frames == 0 && decoder_.stats().frames > 0;
    counters_ = {decoder_.stats(), assembler_.stats(), published_};
    if (first) frame_came_.notify_all();
  }
  watch_silence(received);
}

void ScanStream::publish(const Scan& scan) {
  if (!active_.load(std::memory_order_relaxed)) return;
  auto message = publisher_->borrow();
  if (!message) return;  // every pooled scan is still being read; the publisher counted it
  const auto points = static_cast<double>(scan.ranges_m.size());
  const double increment_rad = 2.0 * std::numbers::pi / points;
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  const WallTime stamp = clock_.wall_now() - (clock_.now() - scan.first_beam);
  message->header.stamp = stamp;
  message->header.frame_id = options_.frame_id;
  message->angle_min = 0.0F;
  message->angle_max = static_cast<float>(2.0 * std::numbers::pi - increment_rad);
  message->angle_increment = static_cast<float>(increment_rad);
  message->time_increment = static_cast<float>(to_seconds(scan.turn) / points);
  message->scan_time = static_cast<float>(to_seconds(scan.turn));
  message->range_min = static_cast<float>(options_.scan.range_min_m);
  message->range_max = static_cast<float>(options_.scan.range_max_m);
  message->ranges.assign(scan.ranges_m.begin(), scan.ranges_m.end());
  message->intensities.assign(scan.intensities.begin(), scan.intensities.end());
  publisher_->publish(std::move(message));
  ++published_;
}

void ScanStream::watch_silence(MonotonicTime now) {
  watch_.look(now, [this] {
    const auto& line = decoder_.stats();
    return fmt::format("{} bytes came so far, {} frames, {} bad checksums", line.bytes, line.frames,
                       line.bad_checksums);
  });
}

void ScanStream::on_silence(MonotonicTime now) { watch_silence(now); }

void ScanStream::on_break(io::StreamFault fault, MonotonicTime) {
  watch_.lose(std::string(io::explain(fault)));
  decoder_.restart();
  assembler_.restart();
  arrival_.restart();
  last_angle_cdeg_ = -1.0;
}

void ScanStream::on_return(MonotonicTime) { logger_.info("{}: the line is back", options_.port_name); }

bool ScanStream::wait_for_frame(Duration limit) {
  UniqueLock lock{mutex_};
  return frame_came_.wait_for(lock.raw(), limit,
                              [this]() NACELLE_REQUIRES(mutex_) { return counters_.line.frames > 0; });
}

LidarCounters ScanStream::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::lidar
