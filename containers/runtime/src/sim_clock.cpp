// SPDX-License-Identifier: Apache-2.0
#include "sim_clock.hpp"

#include <algorithm>
#include <rosgraph_msgs/msg/clock.hpp>

#include "nacelle/base/mutex.hpp"

namespace nacelle::runtime {

void SimTicks::restart(Duration now) {
  last_ = now;
  next_ = now == Duration::zero() ? now : now + period_;
}

bool SimTicks::is_due(Duration now) {
  if (next_ == Duration::zero() || now < last_) restart(now);
  if (now < next_ || now == Duration::zero()) return false;
  const auto missed = (now - next_) / period_;
  skipped_ += static_cast<std::uint64_t>(missed);
  last_ = now;
  next_ += period_ * (missed + 1);
  return true;
}

SimClock::SimClock(const Clock& real, Transport& transport) : real_(real) {
  // rclcpp's ClockQoS.
  EndpointSpec spec{"/clock", &rosgraph_msgs::msg::Clock::message_type(), QoS(1).best_effort(), ""};
  reader_ = transport.create_reader(spec, Taking::Share, this);
  opened_.store(reader_.get(), std::memory_order_release);
}

void SimClock::add(SimTicks& ticks) {
  const LockGuard lock(mutex_);
  ticks.restart(wall_now().since_origin);
  if (std::ranges::find(timers_, &ticks) == timers_.end()) timers_.push_back(&ticks);
}

void SimClock::remove(SimTicks& ticks) {
  const LockGuard lock(mutex_);
  std::erase(timers_, &ticks);
}

bool SimClock::has(const SimTicks& ticks) const {
  const LockGuard lock(mutex_);
  return std::ranges::find(timers_, &ticks) != timers_.end();
}

std::uint64_t SimClock::skipped(const SimTicks& ticks) const {
  const LockGuard lock(mutex_);
  return ticks.skipped_;
}

void SimClock::on_ready() noexcept {
  Reader* const reader = opened_.load(std::memory_order_acquire);
  if (reader == nullptr) return;  // a message that came before is handled with the next one
  const LockGuard lock(mutex_);
  while (Block* const block = reader->take()) {
    const auto& clock = static_cast<const rosgraph_msgs::msg::Clock*>(block->message)->clock;
    const Duration now{clock.sec * std::int64_t{1'000'000'000} + clock.nanosec};
    drop_reference(*block);
    time_ns_.store(now.count(), std::memory_order_release);
    for (SimTicks* const ticks : timers_) {
      if (ticks->is_due(now)) ticks->listener_.on_ready();
    }
  }
}

}  // namespace nacelle::runtime
