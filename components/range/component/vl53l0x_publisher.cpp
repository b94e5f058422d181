// SPDX-License-Identifier: Apache-2.0
#include "range/component/vl53l0x_publisher.hpp"

#include <cmath>
#include <utility>

namespace nacelle::range {

Vl53l0xPublisher::Vl53l0xPublisher(Vl53l0xOptions options, const Clock& clock,
                                   std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher, DeviceWatch& watch)
    : options_(std::move(options)),
      clock_(clock),
      publisher_(std::move(publisher)),
      watch_(watch),
      last_result_(clock.now()) {}

void Vl53l0xPublisher::on_bytes(ByteView bytes, MonotonicTime received) {
  last_result_ = received;
  watch_.heard(received);
  decoder_.feed(bytes, [&](const Vl53l0xResult& result) { publish(result, received - options_.sensor.budget); });
  const LockGuard lock{mutex_};
  counters_.line = decoder_.stats();
}

void Vl53l0xPublisher::on_silence(MonotonicTime now) {
  watch_.look(now, [] { return std::string("it answers, but does not measure"); });
}

void Vl53l0xPublisher::on_break(io::StreamFault fault, MonotonicTime) {
  decoder_.restart();
  watch_.lose(std::string(io::explain(fault)));
}

bool Vl53l0xPublisher::hears() const { return clock_.now() - last_result_ <= silence_of(options_.sensor.period); }

void Vl53l0xPublisher::publish(const Vl53l0xResult& result, MonotonicTime began) {
  const double range_m = range_of(result, options_.least_m, options_.most_m);
  if (std::isnan(range_m)) {
    const LockGuard lock{mutex_};
    ++counters_.invalid;
  }
  auto message = publisher_->borrow();
  if (!message) return;  // every pooled message is still being read; the publisher counted it
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  message->header.stamp = clock_.wall_now() - (clock_.now() - began);
  message->header.frame_id = options_.frame_id;
  message->radiation_type = sensor_msgs::msg::Range::INFRARED;
  message->field_of_view = static_cast<float>(options_.field_of_view_rad);
  message->min_range = static_cast<float>(options_.least_m);
  message->max_range = static_cast<float>(options_.most_m);
  message->range = static_cast<float>(range_m);
  publisher_->publish(std::move(message));
  const LockGuard lock{mutex_};
  ++counters_.published;
}

Vl53l0xCounters Vl53l0xPublisher::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::range
