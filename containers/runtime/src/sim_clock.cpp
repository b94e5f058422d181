// SPDX-License-Identifier: Apache-2.0
#include "sim_clock.hpp"

#include <rosgraph_msgs/msg/clock.hpp>

namespace nacelle::runtime {

SimClock::SimClock(const Clock& real, Transport& transport) : real_(real) {
  // rclcpp's ClockQoS.
  EndpointSpec spec{"/clock", &rosgraph_msgs::msg::Clock::message_type(), QoS(1).best_effort(), ""};
  reader_ = transport.create_reader(spec, Taking::Share, this);
  opened_.store(reader_.get(), std::memory_order_release);
}

void SimClock::on_ready() noexcept {
  Reader* const reader = opened_.load(std::memory_order_acquire);
  // What came before that waits for the next message.
  while (Block* const block = reader != nullptr ? reader->take() : nullptr) {
    const auto& clock = static_cast<const rosgraph_msgs::msg::Clock*>(block->message)->clock;
    time_ns_.store(clock.sec * std::int64_t{1'000'000'000} + clock.nanosec, std::memory_order_release);
    drop_reference(*block);
  }
}

}  // namespace nacelle::runtime
