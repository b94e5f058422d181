// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/drive_loop.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {
namespace {

/// The shortest time after which a stop is due that only a loop that runs can make.
Duration absence_limit_of(const DriveLoop::Settings& settings) {
  Duration limit = settings.motor_watchdog > Duration::zero() ? settings.motor_watchdog : Duration::max();
  for (const auto& source : settings.input.sources) {
    if (source.timeout > Duration::zero()) limit = std::min(limit, source.timeout);
  }
  if (limit == Duration::max()) limit = CommandInput::kNeutralWithoutTimeout;
  return std::max(limit, 2 * settings.period);
}

}  // namespace

const char* code_of(DriveFault::Kind kind) {
  switch (kind) {
    case DriveFault::Kind::SerialLost: return "SERIAL_LOST";
    case DriveFault::Kind::SerialStuck: return "SERIAL_STUCK";
    case DriveFault::Kind::FeedbackLost: return "FEEDBACK_LOST";
  }
  return "UNKNOWN";
}

DriveLoop::DriveLoop(const Settings& settings, BasePort& port, const Clock& clock, CommandInbox& inbox,
                     DriveObserver& observer)
    : settings_(settings),
      absence_limit_(absence_limit_of(settings)),
      port_(port),
      clock_(clock),
      inbox_(inbox),
      observer_(observer),
      input_(settings.input),
      limiter_(settings.limits) {
  NACELLE_EXPECT(settings.period > Duration::zero(), "a control loop needs a period");
}

void DriveLoop::Ears::on_wheel_state(const WheelState& state) {
  loop_.heard_at_ = state.captured_at;
  loop_.observer_.on_wheel_state(state);
}

// The wheels are stopped in this cycle, whatever the board does by itself; when the fault has gone, `rearm` decides.
void DriveLoop::Ears::on_board_fault(const char* fault) {
  loop_.board_fault_.store(fault, std::memory_order_relaxed);
  const bool was_held = loop_.input_.is_held(Hold::BoardFault);
  if (fault == nullptr) {
    if (was_held) loop_.input_.release(Hold::BoardFault, loop_.clock_.now());
    return;
  }
  if (was_held) return;
  ++loop_.stats_.board_faults;
  loop_.input_.hold(Hold::BoardFault);
  loop_.limiter_.reset();
  loop_.unwritten_.reset();
  loop_.stops_at_once_ = true;
}

void DriveLoop::arm(MonotonicTime now) {
  board_fault_.store(nullptr, std::memory_order_relaxed);
  input_.release(Hold::BoardFault, now);
  input_.arm(now);
  input_.release(Hold::LineLost, now);
  lost_at_.reset();
  silent_at_.reset();
  backoff_.reset();
  limiter_.reset();
  unwritten_.reset();
  input_.release(Hold::Stopped, now);
  stops_at_arm_ = stops_from_outside();
  due_ = now + settings_.period;
  cycled_at_ = now;
  heard_at_ = now;
  written_at_ = now;
  stop_.store(false);
}

void DriveLoop::begin_without_board() {
  silent_at_ = cycled_at_;
  silence_told_ = false;
  next_attempt_ = cycled_at_ + backoff_.next();
  input_.hold(Hold::LineLost);
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

std::uint64_t DriveLoop::stops_from_outside() const {
  return inbox_.stops_from_outside == nullptr ? 0 : inbox_.stops_from_outside->load();
}

void DriveLoop::apply_stops() {
  bool is_new = input_.take_holds(inbox_);
  if (stops_from_outside() != stops_at_arm_ && !input_.is_held(Hold::Stopped)) {
    input_.hold(Hold::Stopped);
    is_new = true;
  }
  if (std::exchange(stops_at_once_, false)) is_new = true;
  if (is_new) static_cast<void>(port_.stop());  // the following cycle repeats the stop
}

Result<void, DriveFault> DriveLoop::listen() {
  while (clock_.now() < due_ && !stop_.load(std::memory_order_relaxed)) {
    apply_stops();
    if (lost_at_) {
      port_.rest_until(due_);
    } else if (const auto heard = port_.read_until(due_, ears_); !heard) {
      static_cast<void>(port_.stop());
      if (auto kept = lose_line(heard.error()); !kept) return kept;
    }
  }
  return {};
}

Result<void, DriveFault> DriveLoop::lose_line(BaseFault why) {
  ++stats_.lost;
  const bool is_waited_for = settings_.waits_for_board || settings_.reopen_limit > Duration::zero();
  if (!is_waited_for || why == BaseFault::NotSendable) return err(DriveFault{DriveFault::Kind::SerialLost, why});
  const MonotonicTime now = clock_.now();
  lost_at_ = now;
  silent_at_.reset();
  line_fault_ = why;
  next_attempt_ = now + backoff_.next();
  if (settings_.waits_for_board) observer_.on_board_lost(explain(why));
  input_.hold(Hold::LineLost);
  limiter_.reset();
  unwritten_.reset();
  return {};
}

Result<void, DriveFault> DriveLoop::bring_line_back(MonotonicTime now) {
  if (now >= next_attempt_) {
    next_attempt_ = now + backoff_.next();
    const auto opened = port_.reopen();
    if (opened) {
      ++stats_.reopened;
      lost_at_.reset();
      heard_at_ = written_at_ = clock_.now();
      if (settings_.waits_for_board) {
        silent_at_ = heard_at_;  // held until the board speaks
        silence_told_ = false;
      } else {
        input_.release(Hold::LineLost, heard_at_);
      }
      return {};
    }
    line_fault_ = opened.error();
    if (settings_.waits_for_board) observer_.on_board_lost(explain(line_fault_));
  }
  if (!settings_.waits_for_board && now - *lost_at_ > settings_.reopen_limit)
    return err(DriveFault{DriveFault::Kind::SerialLost, line_fault_});
  return {};
}

void DriveLoop::lose_board(std::string_view why, MonotonicTime now) {
  ++stats_.lost;
  silent_at_ = now;
  silence_told_ = true;
  next_attempt_ = now + backoff_.next();
  input_.hold(Hold::LineLost);
  limiter_.reset();
  unwritten_.reset();
  observer_.on_board_lost(why);
  static_cast<void>(port_.stop());
}

void DriveLoop::bring_board_back(MonotonicTime now) {
  if (heard_at_ > *silent_at_ && now - written_at_ <= settings_.silence_report) {
    silent_at_.reset();
    backoff_.reset();
    input_.release(Hold::LineLost, now);
    observer_.on_board_back(now);
    return;
  }
  if (now < next_attempt_) return;
  next_attempt_ = now + backoff_.next();
  // A line that is back without its board may have another device.
  if (!silence_told_ && now - *silent_at_ > settings_.silence_report) {
    silence_told_ = true;
    if (const std::string why = port_.why_no_state(now - *silent_at_); !why.empty()) observer_.on_board_lost(why);
  }
  // The board may have lost power while the line stayed up, and with it its settings.
  if (const auto started = port_.start(); !started) line_fault_ = started.error();
}

Result<void, DriveFault> DriveLoop::watch_board(MonotonicTime now) {
  if (lost_at_) return {};
  if (settings_.waits_for_board) {
    if (silent_at_) {
      bring_board_back(now);
    } else if (now - heard_at_ > settings_.silence_report) {
      const std::string why = port_.why_no_state(now - heard_at_);
      lose_board(why.empty() ? "the motor board says nothing" : why, now);
    } else if (now - written_at_ > settings_.silence_report) {
      lose_board(explain(BaseFault::LineStuck), now);
    }
    return {};
  }
  if (settings_.silence_limit > Duration::zero() && now - heard_at_ > settings_.silence_limit) {
    static_cast<void>(port_.stop());
    return err(DriveFault{DriveFault::Kind::FeedbackLost});
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
  const std::uint32_t orders = inbox_.orders.load(std::memory_order_acquire);
  apply_stops();
  const Duration since_last = now - std::exchange(cycled_at_, now);
  // What came while this loop was away was not read yet: that is no silence of the board.
  if (since_last > 2 * settings_.period && !silent_at_) {
    heard_at_ = std::min(now, heard_at_ + since_last);
    written_at_ = std::min(now, written_at_ + since_last);
  }
  if (since_last > absence_limit_) {
    input_.forget(now);
    limiter_.reset();
    unwritten_.reset();
  }
  const double step_s = elapsed_periods(now) * to_seconds(settings_.period);
  ++stats_.cycles;
  const BodyTwist twist = next_twist(now, step_s);
  stats_.commands = input_.stats();
  const std::size_t selected = input_.selected();
  look_.store({input_.state(), input_.holds(), input_.waits_for_neutral(now),
               selected < Look::kNobody ? static_cast<std::uint8_t>(selected) : Look::kNobody},
              std::memory_order_relaxed);
  orders_followed_.store(orders, std::memory_order_release);
  if (lost_at_) return bring_line_back(now);

  if (auto driven = drive(twist); !driven) return driven;
  observer_.on_cycle(twist, now);

  return watch_board(now);
}

BodyTwist DriveLoop::next_twist(MonotonicTime now, double step_s) {
  if (DriveCommand newest; input_.take(inbox_, now, newest)) unwritten_ = newest;
  const BodyTwist asked = input_.wanted(now);
  if (input_.state() != CommandInput::State::Driving) {
    limiter_.reset();
    return {};
  }
  const BodyTwist wanted = within_wheel_rate(settings_.geometry, asked, port_.max_wheel_rate());
  // A jerk limit can carry the speed over the wanted one for a few cycles: the wheels' own limit has the last word.
  return within_wheel_rate(settings_.geometry, limiter_.limit(wanted, step_s), port_.max_wheel_rate());
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
    return lose_line(written.error());
  }
  // A line may be stuck for a moment; the next cycle tries again, with the newest command.
  if (!settings_.waits_for_board && settings_.silence_limit > Duration::zero() &&
      now - written_at_ > settings_.silence_limit) {
    return err(DriveFault{DriveFault::Kind::SerialStuck, written.error()});
  }
  return {};
}

}  // namespace nacelle::diff_drive
