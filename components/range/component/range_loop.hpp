// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <sensor_msgs/msg/range.hpp>
#include <string>
#include <thread>

#include "nacelle/base/mutex.hpp"
#include "nacelle/node/device_watch.hpp"
#include "range/port/hc_sr04.hpp"

namespace nacelle::range {

/// The parameters of the component.
struct RangeOptions {
  EchoSettings lines{};
  std::string frame_id = "range_link";
  double rate_hz = 10.0;
  double least_m = 0.02, most_m = 4.0;
  double field_of_view_rad = 0.26;  ///< Source: HC-SR04 User Guide, "measuring angle 15 degree".
  double temperature_c = 20.0;
  DeviceOptions device{};
  Duration silence_limit = 1s;  ///< With device_lost: fault, no answer for this long is one.
};

/// What the thread counted.
struct RangeCounters {
  std::uint64_t measured{}, unanswered{}, published{};
};

/// Measures at a steady pace on a thread of its own, as long as it lives.
///
/// Errors: the watch says when the sensor does not answer, or its chip is gone; the lines are then opened again.
class RangeLoop {
 public:
  using OpenLines = std::function<Result<std::unique_ptr<EchoLines>, Problem>(const EchoSettings&, const Clock&)>;

  /// `lines`: null if the chip is absent.
  RangeLoop(RangeOptions options, const Clock& clock, OpenLines open_lines, std::unique_ptr<EchoLines>& lines,
            std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher, DeviceWatch& watch,
            std::function<void(const std::string&)> on_exception);
  RangeLoop(const RangeLoop&) = delete;
  RangeLoop& operator=(const RangeLoop&) = delete;
  ~RangeLoop();

  [[nodiscard]] RangeCounters counters() const;

 private:
  void run();
  void measure();
  void publish(Duration echo, MonotonicTime at);
  /// Returns false when the thread is to end.
  [[nodiscard]] bool pause(Duration length);

  const RangeOptions options_;
  const Clock& clock_;
  const OpenLines open_lines_;
  const std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher_;
  DeviceWatch& watch_;
  const std::function<void(const std::string&)> on_exception_;
  mutable Mutex mutex_;
  std::condition_variable end_asked_;
  bool ended_ NACELLE_GUARDED_BY(mutex_) = false;
  RangeCounters counters_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<EchoLines>& lines_;  // replaced under the lock only
  std::thread thread_;                 // last: it starts when everything above is there
};

}  // namespace nacelle::range
