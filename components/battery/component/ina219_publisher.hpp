// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <sensor_msgs/msg/battery_state.hpp>
#include <string>

#include "battery/component/ina219.hpp"
#include "battery/model/battery_model.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/io/reader_thread.hpp"
#include "nacelle/node/device_watch.hpp"

namespace nacelle::battery {

/// The parameters of the component.
struct Ina219Options {
  std::string bus = "/dev/i2c-1";
  std::uint8_t address = 0x40;
  double shunt_ohms = 0.1;
  Duration period = 1s;
  BatterySettings battery{};
  Ina219Setup setup{};
  std::uint8_t technology = sensor_msgs::msg::BatteryState::POWER_SUPPLY_TECHNOLOGY_UNKNOWN;
  double design_capacity_ah = 0.0;  ///< 0: unknown.
  std::string location{};
  DeviceOptions device{};
  Duration port_timeout = 1s;   ///< How long configure waits for a bus that is required.
  Duration silence_limit = 5s;  ///< With device_lost: fault, no reading for this long is one.
};

/// What the thread counted.
struct Ina219Counters {
  Ina219Decoder::Stats line{};
  /// Readings are in one place: line.readings == published + unready + strange, and those that no message was free for.
  std::uint64_t published{}, unready{}, strange{};
  std::uint64_t unmeasurable{};  ///< Of those published, without a current: above what is measured.
};

/// From readings to messages, on the reading thread.
///
/// Stamp: when the registers were read; the mean in them ends then.
/// Allocates: nothing once the publisher's messages have their size.
class Ina219Publisher final : public io::ByteSink {
 public:
  Ina219Publisher(Ina219Options options, const Clock& clock,
                  std::shared_ptr<Publisher<sensor_msgs::msg::BatteryState>> publisher, const Logger& logger,
                  DeviceWatch& watch);

  void on_bytes(ByteView bytes, MonotonicTime received) override;
  void on_silence(MonotonicTime now) override;
  void on_break(io::StreamFault fault, MonotonicTime now) override;
  void on_refusal(io::StreamFault fault) override { watch_.lose(std::string(io::explain(fault))); }
  void on_return(MonotonicTime) override { is_set_up_ = true; }
  /// False: the chip has lost its settings.
  [[nodiscard]] bool hears() const override { return is_set_up_; }

  /// Threads: any.
  [[nodiscard]] Ina219Counters counters() const;

 private:
  void take(const Ina219Reading& reading, MonotonicTime received);
  void publish(const BatteryReading& battery, MonotonicTime at);
  void tell_overflow(bool has_current);

  const Ina219Options options_;
  const Clock& clock_;
  const std::shared_ptr<Publisher<sensor_msgs::msg::BatteryState>> publisher_;
  const Logger& logger_;
  DeviceWatch& watch_;
  bool is_set_up_ = true;
  bool is_overflow_told_ = false;
  Ina219Decoder decoder_;
  mutable Mutex mutex_;
  Ina219Counters counters_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle::battery
