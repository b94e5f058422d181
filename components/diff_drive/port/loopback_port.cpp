// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/loopback_port.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nacelle::diff_drive {

LoopbackPort::LoopbackPort(const Clock& clock, Settings settings, Wait wait)
    : clock_(clock), settings_(settings), wait_(std::move(wait)) {
  wheels_.voltage_v = settings.voltage_v;
  wheels_.captured_at = clock.now();
  next_state_ = wheels_.captured_at + settings.state_period;
}

void LoopbackPort::turn_wheels_until(MonotonicTime now) {
  const double elapsed_s = to_seconds(now - wheels_.captured_at);
  wheels_.left_rad += wheels_.rates.left_rps * elapsed_s;
  wheels_.right_rad += wheels_.rates.right_rps * elapsed_s;
  wheels_.captured_at = now;
}

Result<void, BaseFault> LoopbackPort::start() {
  next_state_ = clock_.now() + settings_.state_period;
  return stop();
}

void LoopbackPort::rest_until(MonotonicTime deadline) {
  if (clock_.now() >= deadline) return;
  if (wait_) {
    wait_(deadline);
  } else {
    static_cast<void>(io::wait_readable(-1, bell_, clock_, deadline));
  }
}

Result<void, BaseFault> LoopbackPort::read_until(MonotonicTime deadline, WheelStateSink& sink) {
  const MonotonicTime until = std::min(deadline, next_state_);
  rest_until(until);
  const MonotonicTime now = clock_.now();
  if (now < next_state_) return {};
  turn_wheels_until(now);
  next_state_ += settings_.state_period;
  // A reader that was away gets one state, not all that it missed.
  if (next_state_ <= now) next_state_ = now + settings_.state_period;
  ++stats_.states;
  sink.on_wheel_state(wheels_);
  return {};
}

Result<void, BaseFault> LoopbackPort::write(const WheelRates& rates) {
  if (!std::isfinite(rates.left_rps) || !std::isfinite(rates.right_rps)) return err(BaseFault::NotSendable);
  turn_wheels_until(clock_.now());
  wheels_.rates = rates;
  ++stats_.commands;
  return {};
}

}  // namespace nacelle::diff_drive
