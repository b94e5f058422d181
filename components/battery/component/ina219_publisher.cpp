// SPDX-License-Identifier: Apache-2.0
#include "battery/component/ina219_publisher.hpp"

#include <limits>
#include <utility>

namespace nacelle::battery {
namespace {

using sensor_msgs::msg::BatteryState;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

float or_unknown(const std::optional<double>& value) { return value ? static_cast<float>(*value) : kUnknown; }

std::uint8_t status_of(BatteryStatus status) {
  switch (status) {
    case BatteryStatus::Charging: return BatteryState::POWER_SUPPLY_STATUS_CHARGING;
    case BatteryStatus::Discharging: return BatteryState::POWER_SUPPLY_STATUS_DISCHARGING;
    case BatteryStatus::Idle: return BatteryState::POWER_SUPPLY_STATUS_NOT_CHARGING;
    case BatteryStatus::Unknown: break;
  }
  return BatteryState::POWER_SUPPLY_STATUS_UNKNOWN;
}

}  // namespace

Ina219Publisher::Ina219Publisher(Ina219Options options, const Clock& clock,
                                 std::shared_ptr<Publisher<BatteryState>> publisher, const Logger& logger,
                                 DeviceWatch& watch)
    : options_(std::move(options)), clock_(clock), publisher_(std::move(publisher)), logger_(logger), watch_(watch) {}

void Ina219Publisher::on_bytes(ByteView bytes, MonotonicTime received) {
  decoder_.feed(bytes, [&](const Ina219Reading& reading) { take(reading, received); });
  const LockGuard lock{mutex_};
  counters_.line = decoder_.stats();
}

void Ina219Publisher::on_silence(MonotonicTime now) {
  watch_.look(now, [] { return std::string("it answers, but measures nothing"); });
}

void Ina219Publisher::on_break(io::StreamFault fault, MonotonicTime) {
  decoder_.restart();
  watch_.lose(std::string(io::explain(fault)));
}

void Ina219Publisher::take(const Ina219Reading& reading, MonotonicTime received) {
  is_set_up_ = reading.config == options_.setup.config;
  if (!is_set_up_ || !reading.is_converted) {
    const LockGuard lock{mutex_};
    ++(is_set_up_ ? counters_.unready : counters_.strange);
    return;
  }
  watch_.heard(received);
  const BatteryReading battery = battery_reading(reading, options_.setup, options_.battery);
  tell_overflow(battery.current_a.has_value());
  publish(battery, received);
}

void Ina219Publisher::tell_overflow(bool has_current) {
  if (!has_current) {
    const LockGuard lock{mutex_};
    ++counters_.unmeasurable;
  }
  // Once per bad spell.
  if (!std::exchange(is_overflow_told_, !has_current) && !has_current)
    logger_.warn("the battery's current is above max_current ({} A), so it is not known; set it higher",
                 options_.battery.max_current_a);
}

void Ina219Publisher::publish(const BatteryReading& battery, MonotonicTime at) {
  if (!publisher_) return;
  auto message = publisher_->borrow();
  if (!message) return;  // every pooled message is still being read; the publisher counted it
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  message->header.stamp = clock_.wall_now() - (clock_.now() - at);
  message->header.frame_id.clear();
  message->voltage = static_cast<float>(battery.voltage_v);
  message->temperature = kUnknown;
  message->current = or_unknown(battery.current_a);
  message->charge = kUnknown;
  message->capacity = kUnknown;
  message->design_capacity =
      options_.design_capacity_ah > 0.0 ? static_cast<float>(options_.design_capacity_ah) : kUnknown;
  message->percentage = or_unknown(battery.percentage);
  message->power_supply_status = status_of(battery.status);
  message->power_supply_health = BatteryState::POWER_SUPPLY_HEALTH_UNKNOWN;
  message->power_supply_technology = options_.technology;
  message->present = battery.is_present;
  message->cell_voltage.clear();
  message->cell_temperature.clear();
  message->location = options_.location;
  message->serial_number.clear();
  publisher_->publish(std::move(message));
  const LockGuard lock{mutex_};
  ++counters_.published;
}

Ina219Counters Ina219Publisher::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::battery
