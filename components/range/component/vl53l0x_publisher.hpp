// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <sensor_msgs/msg/range.hpp>
#include <string>

#include "nacelle/base/mutex.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/node/device_watch.hpp"
#include "range/component/vl53l0x.hpp"

namespace nacelle::range {

/// The parameters of the component.
struct Vl53l0xOptions {
  std::string bus = "/dev/i2c-1";
  Vl53l0x::Settings sensor{};
  std::string frame_id = "range_link";
  double least_m = 0.03, most_m = 2.0;
  double field_of_view_rad = 0.44;  ///< Source: ST, VL53L0X data sheet DocID029104, field of view 25 degrees.
  DeviceOptions device{};
  Duration port_timeout = 1s;   ///< How long configure waits for a bus that is required.
  Duration silence_limit = 1s;  ///< With device_lost: fault, no result for this long is one.
};

/// What the thread counted.
struct Vl53l0xCounters {
  Vl53l0xDecoder::Stats line{};
  std::uint64_t invalid{}, published{};
};

/// From results to messages, on the reading thread.
///
/// Stamp: when the measurement began, by the time at which its result was seen and the timing budget; some milliseconds late at most.
/// Allocates: nothing once the publisher's messages have their size.
class Vl53l0xPublisher final : public io::ByteSink {
 public:
  Vl53l0xPublisher(Vl53l0xOptions options, const Clock& clock,
                   std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher, DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override;
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  void on_return(MonotonicTime now) override { last_result_ = now; }
  [[nodiscard]] bool hears() const override;

  /// Threads: any.
  [[nodiscard]] Vl53l0xCounters counters() const;

 private:
  void publish(const Vl53l0xResult& result, MonotonicTime began);

  const Vl53l0xOptions options_;
  const Clock& clock_;
  const std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher_;
  DeviceWatch& watch_;
  MonotonicTime last_result_;
  Vl53l0xDecoder decoder_;
  mutable Mutex mutex_;
  Vl53l0xCounters counters_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::range
