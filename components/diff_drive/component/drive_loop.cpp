// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/drive_loop.hpp"

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {

const char* code_of(DriveFault::Kind kind) {
  switch (kind) {
    case DriveFault::Kind::SerialLost: return "SERIAL_LOST";
    case DriveFault::Kind::SerialStuck: return "SERIAL_STUCK";
    case DriveFault::Kind::FeedbackLost: return "FEEDBACK_LOST";
  }
  return "UNKNOWN";
}

DriveLoop::DriveLoop(const Settings& settings, BasePort& port, const Clock& clock, LatestValue<DriveCommand>& commands,
                     DriveObserver& observer)
    : settings_(settings),
      port_(port),
      clock_(clock),
      commands_(commands),
      observer_(observer),
      watch_(settings.command_timeout),
      limiter_(settings.limits) {
  NACELLE_EXPECT(settings.period > Duration::zero(), "a control loop needs a period");
}

void DriveLoop::Ears::on_wheel_state(const WheelState& state) {
  loop_.heard_at_ = state.captured_at;
  loop_.observer_.on_wheel_state(state);
}

void DriveLoop::arm(MonotonicTime now) {
  watch_.arm(now);
  limiter_.reset();
  unwritten_.reset();
  due_ = now + settings_.period;
  heard_at_ = now;
  written_at_ = now;
  stop_.store(false);
}

void DriveLoop::stop() noexcept {
  stop_.store(true);
  port_.interrupt();
}

Result<void, DriveFault> DriveLoop::run() {
  while (!stop_.load(std::memory_order_relaxed)) {
    if (auto done = cycle(); !done) return done;
  }
  return {};
}

Result<void, DriveFault> DriveLoop::listen() {
  while (clock_.now() < due_ && !stop_.load(std::memory_order_relaxed)) {
    if (const auto heard = port_.read_until(due_, ears_); !heard) {
      static_cast<void>(port_.stop());
      return err(DriveFault{DriveFault::Kind::SerialLost, heard.error()});
    }
  }
  return {};
}

double DriveLoop::elapsed_periods(MonotonicTime now) {
  // Whole periods, so that the limits see an even step in spite of a jitter of microseconds; at most two of them, so
  // that the first command after a long stall is a step as small as always.
  const auto late = (now - due_) / settings_.period;
  stats_.skipped += static_cast<std::uint64_t>(std::max<std::int64_t>(late, 0));
  due_ += (late + 1) * settings_.period;
  return late >= 1 ? 2.0 : 1.0;
}

Result<void, DriveFault> DriveLoop::cycle() {
  if (auto heard = listen(); !heard) return heard;
  if (stop_.load(std::memory_order_relaxed)) return {};

  const MonotonicTime now = clock_.now();
  const double step_s = elapsed_periods(now) * to_seconds(settings_.period);
  ++stats_.cycles;
  if (const auto command = commands_.take(); command && watch_.take(*command)) unwritten_ = command;
  const BodyTwist wanted = within_wheel_rate(settings_.geometry, watch_.wanted(now), port_.max_wheel_rate());
  // A jerk limit can carry the speed over the wanted one for a few cycles: the wheels' own limit has the last word.
  const BodyTwist twist = within_wheel_rate(settings_.geometry, limiter_.limit(wanted, step_s), port_.max_wheel_rate());
  stats_.commands = watch_.stats();

  if (auto driven = drive(twist); !driven) return driven;
  observer_.on_cycle(twist, now);

  if (settings_.silence_limit > Duration::zero() && now - heard_at_ > settings_.silence_limit) {
    static_cast<void>(port_.stop());
    return err(DriveFault{DriveFault::Kind::FeedbackLost});
  }
  return {};
}

Result<void, DriveFault> DriveLoop::drive(const BodyTwist& twist) {
  const auto written = twist == BodyTwist{} ? port_.stop() : port_.write(wheel_rates(settings_.geometry, twist));
  const MonotonicTime now = clock_.now();
  if (written) {
    written_at_ = now;
    if (unwritten_) observer_.on_command_written(now - unwritten_->published_at);
    unwritten_.reset();
    return {};
  }
  ++stats_.unwritten;
  if (written.error() != BaseFault::LineStuck) {
    static_cast<void>(port_.stop());
    return err(DriveFault{DriveFault::Kind::SerialLost, written.error()});
  }
  // A line may be stuck for a moment; the next cycle tries again, with the newest command.
  if (settings_.silence_limit > Duration::zero() && now - written_at_ > settings_.silence_limit) {
    return err(DriveFault{DriveFault::Kind::SerialStuck, written.error()});
  }
  return {};
}

}  // namespace nacelle::diff_drive
