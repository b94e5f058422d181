// SPDX-License-Identifier: Apache-2.0
#include "session/clock_jump.hpp"

#include <fmt/format.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>

namespace nacelle::session {

std::string ClockJumpReport::tell(Duration step, WallTime now) {
  using diagnostic_msgs::msg::DiagnosticArray;
  using diagnostic_msgs::msg::DiagnosticStatus;
  if (!writer_) {
    writer_ = transport_.create_writer({"/diagnostics", &DiagnosticArray::message_type(), QoS{10}, node_});
  }
  const std::string text = fmt::format("the wall clock was set by {:+.3f} s", to_seconds(step));
  if (Block* const block = writer_->borrow(); block != nullptr) {
    auto& message = *static_cast<DiagnosticArray*>(block->message);
    message.header.stamp = now;
    message.header.frame_id.clear();
    message.status.resize(1);
    auto& status = message.status[0];
    status.level = DiagnosticStatus::WARN;
    status.name = container_ + ": clock_jump";
    status.message = text;
    status.hardware_id.clear();
    status.values.resize(1);
    status.values[0].key = "step_s";
    status.values[0].value = fmt::format("{:.6f}", to_seconds(step));
    static_cast<void>(writer_->publish(*block));
  }
  return "clock_jump: " + text + "; control and timeouts run on the monotonic clock and go on";
}

}  // namespace nacelle::session
