// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/pwm_base_port.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {
namespace {

/// An older reading of the encoders is none of this cycle.
constexpr Duration kFresh = 1ms;

const char* text_of(std::size_t side, WheelWatch::Finding finding) {
  if (finding == WheelWatch::Finding::Reversed) {
    return side == 0 ? "the left wheel's encoder counts against its motor (left_reversed, pwm.left_encoder_reversed, "
                       "or two wires that are swapped)"
                     : "the right wheel's encoder counts against its motor (right_reversed, "
                       "pwm.right_encoder_reversed, or two wires that are swapped)";
  }
  return side == 0 ? "the left wheel does not turn at full output: it is blocked, has no supply, or its encoder is not "
                     "connected"
                   : "the right wheel does not turn at full output: it is blocked, has no supply, or its encoder is "
                     "not connected";
}

int sign_of(double value) { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

}  // namespace

PwmBasePort::Side::Side(const Wheel& wheel, const Settings& settings)
    : motor_sign(wheel.is_reversed ? -1.0 : 1.0),
      rad_per_count((wheel.is_reversed != wheel.encoder_is_reversed ? -2.0 : 2.0) * std::numbers::pi /
                    settings.counts_per_turn),
      pid(settings.pid),
      watch(settings.stall_limit_s) {}

PwmBasePort::PwmBasePort(std::unique_ptr<HBridges> motors, std::unique_ptr<WheelEncoders> encoders, const Clock& clock,
                         const Settings& settings, Wait wait)
    : motors_(std::move(motors)),
      encoders_(std::move(encoders)),
      clock_(clock),
      settings_(settings),
      wait_(std::move(wait)),
      sides_{Side{settings.left, settings}, Side{settings.right, settings}} {
  NACELLE_EXPECT(settings.counts_per_turn > 0.0, "encoders count");
}

Result<void, BaseFault> PwmBasePort::start() {
  if (auto stopped = stop(); !stopped) return stopped;
  forget();
  return sample();
}

// A wheel may have been turned by hand meanwhile: that is no speed.
void PwmBasePort::forget() {
  for (Side& side : sides_) {
    side.rate.reset();
    side.rate_rps = 0.0;
    side.finding = WheelWatch::Finding::None;
  }
  fault_ = nullptr;
}

Result<void, BaseFault> PwmBasePort::reopen() {
  const bool has_motors = motors_->reopen();
  if (!encoders_->reopen()) return err(BaseFault::EncodersLost);
  if (!has_motors) return err(BaseFault::OutputLost);
  return start();
}

void PwmBasePort::rest_until(MonotonicTime deadline) {
  if (wait_) {
    wait_(deadline);
  } else {
    was_woken_ = io::wait_readable(-1, bell_, clock_, deadline) == io::Wake::Woken;
  }
}

Result<void, BaseFault> PwmBasePort::sample() {
  if (!encoders_->read(sides_[0].counted, sides_[1].counted)) return err(BaseFault::EncodersLost);
  sampled_at_ = clock_.now();
  for (Side& side : sides_) {
    side.rate_rps = side.rate.update(side.counted.count, side.counted.edge_at, sampled_at_) * side.rad_per_count;
    side.angle_rad = static_cast<double>(side.counted.count) * side.rad_per_count;
  }
  return {};
}

Result<void, BaseFault> PwmBasePort::read_until(MonotonicTime deadline, WheelStateSink& sink) {
  if (clock_.now() >= deadline) return {};
  while (clock_.now() < deadline) {
    const Duration left = deadline - clock_.now();
    const bool is_last = left <= encoders_->longest_rest();
    rest_until(is_last ? deadline : clock_.now() + encoders_->longest_rest());
    if (std::exchange(was_woken_, false)) return {};
    // Only the kernel's memory of edges is emptied: a rate is that of a whole cycle.
    if (!is_last && !encoders_->read(sides_[0].counted, sides_[1].counted)) return err(BaseFault::EncodersLost);
  }
  if (auto read = sample(); !read) return read;
  ++stats_.states;
  report_faults(sampled_at_, sink);
  sink.on_wheel_state(
      {sides_[0].angle_rad, sides_[1].angle_rad, {sides_[0].rate_rps, sides_[1].rate_rps}, std::nullopt, sampled_at_});
  return {};
}

void PwmBasePort::report_faults(MonotonicTime now, WheelStateSink& sink) {
  for (std::size_t side = 0; side < sides_.size(); ++side) {
    const auto finding = std::exchange(sides_[side].finding, WheelWatch::Finding::None);
    if (finding == WheelWatch::Finding::None) continue;
    fault_ = text_of(side, finding);
    fault_at_ = now;
  }
  if (fault_ == nullptr) return;
  if (now - fault_at_ > kFaultHold) fault_ = nullptr;
  sink.on_board_fault(fault_);
}

void PwmBasePort::control(Side& side, double wanted_rps, double dt_s) const {
  const double output_before = side.output;
  // A wheel that shall stand is switched off: at a standstill a controller would push to and fro.
  if (wanted_rps == 0.0) {
    side.pid.reset();
    side.watch.reset();
    side.output = 0.0;
    return;
  }
  side.output = side.pid.update(wanted_rps, side.rate_rps, dt_s);
  const bool is_limited = std::abs(output_before) >= settings_.pid.output_limit &&
                          sign_of(output_before) == sign_of(side.output) && sign_of(side.output) == sign_of(wanted_rps);
  const auto finding = side.watch.update(is_limited, sign_of(side.output) * side.rate_rps * dt_s, dt_s);
  if (finding != WheelWatch::Finding::None) side.finding = finding;
}

double PwmBasePort::share_of(const Side& side) const {
  return side.motor_sign * beyond_dead_band(side.output, settings_.min_duty, settings_.max_duty);
}

Result<void, BaseFault> PwmBasePort::write(const WheelRates& rates) {
  const double most = max_wheel_rate();
  const auto is_sendable = [most](double rate_rps) {
    return std::isfinite(rate_rps) && std::abs(rate_rps) <= most * (1.0 + 1e-9);
  };
  if (!is_sendable(rates.left_rps) || !is_sendable(rates.right_rps)) return err(BaseFault::NotSendable);
  if (clock_.now() - sampled_at_ > kFresh) {
    if (auto read = sample(); !read) return read;
  }
  const MonotonicTime now = clock_.now();
  const double dt_s = is_stopped_ ? 0.0 : to_seconds(now - controlled_at_);
  controlled_at_ = now;
  is_stopped_ = false;
  control(sides_[0], rates.left_rps, dt_s);
  control(sides_[1], rates.right_rps, dt_s);
  const double left = share_of(sides_[0]), right = share_of(sides_[1]);
  encoders_->drive(sign_of(left), sign_of(right));
  if (!motors_->set(left, right)) return err(BaseFault::OutputLost);
  ++stats_.commands;
  return {};
}

Result<void, BaseFault> PwmBasePort::stop() {
  is_stopped_ = true;
  for (Side& side : sides_) {
    side.pid.reset();
    side.watch.reset();
    side.output = 0.0;
  }
  if (!motors_->stop()) return err(BaseFault::OutputLost);
  ++stats_.commands;
  return {};
}

BasePort::Stats PwmBasePort::stats() const {
  Stats stats = stats_;
  stats.edges = encoders_->stats().edges;
  stats.edges_lost = encoders_->stats().lost;
  return stats;
}

}  // namespace nacelle::diff_drive
