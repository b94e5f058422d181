// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/time_reference.hpp>

#include "gps/component/gps_options.hpp"
#include "gps/protocol/nmea_framer.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/arrival_filter.hpp"
#include "nacelle/io/reader_thread.hpp"

namespace nacelle::gps {

/// The three topics of the component.
struct GpsPublishers {
  std::shared_ptr<Publisher<sensor_msgs::msg::NavSatFix>> fix;
  std::shared_ptr<Publisher<geometry_msgs::msg::TwistStamped>> velocity;
  std::shared_ptr<Publisher<sensor_msgs::msg::TimeReference>> time;
};

/// What the reading thread counted.
struct GpsCounters {
  NmeaFramer::Stats line{};
  /// Sentences are in one place: line.sentences == used + other + malformed.
  std::uint64_t used{}, other{}, malformed{};
  std::uint64_t published{};  ///< Messages on `fix`.
};

/// From bytes to published fixes, on the reading thread.
///
/// A receiver sends the sentences of one moment in a burst. They share a stamp: when the first byte of the burst was received, with the
/// thread's delays removed by an ArrivalFilter, since the times in the sentences are exact. How long the receiver computed before that
/// (50 to 200 ms are usual) is not known, and not taken off.
/// Allocates: nothing once the publishers' messages have their size.
class GpsStream final : public io::ByteSink {
 public:
  GpsStream(const GpsOptions& options, const Clock& clock, GpsPublishers publishers, const Logger& logger,
            DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override { watch_silence(now); }
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  void on_return(MonotonicTime now) override;

  /// Messages leave only while it is set. Threads: any.
  void set_active(bool active) { active_.store(active, std::memory_order_relaxed); }
  /// Waits, by an event, for the first sentence. Threads: any other than the reading one.
  [[nodiscard]] bool wait_for_sentence(Duration limit);
  /// Threads: any.
  [[nodiscard]] GpsCounters counters() const;

 private:
  void on_sentence(const NmeaSentence& sentence);
  /// Returns when the burst of this moment began.
  MonotonicTime moment_of(Duration utc, MonotonicTime started);
  void publish_fix(const Gga& gga, std::string_view talker, MonotonicTime moment);
  void publish_velocity(std::optional<double> speed_mps, std::optional<double> course_deg, MonotonicTime moment);
  void publish_time(const Rmc& rmc, MonotonicTime moment);
  void watch_silence(MonotonicTime now);
  [[nodiscard]] bool is_active() const { return active_.load(std::memory_order_relaxed); }
  [[nodiscard]] WallTime stamp_of(MonotonicTime moment) const;

  const GpsOptions options_;
  const Clock& clock_;
  const GpsPublishers publishers_;
  const Logger& logger_;
  DeviceWatch& watch_;

  NmeaFramer framer_;
  ErrorModel errors_;
  io::ArrivalFilter arrival_;
  std::optional<Duration> utc_;  // of the burst under way
  MonotonicTime moment_{};
  bool hears_rmc_ = false;  // it has the velocity with its time; VTG has it without
  bool has_fix_ = false;    // as last logged
  std::uint64_t used_ = 0, other_ = 0, malformed_ = 0, published_ = 0;
  std::atomic<bool> active_{false};

  mutable Mutex mutex_;
  std::condition_variable sentence_came_;
  GpsCounters counters_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::gps
