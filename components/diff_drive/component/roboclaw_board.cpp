// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/roboclaw_board.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {
namespace {

constexpr Duration kBatteryPeriod = 1s;

}  // namespace

RoboclawBoard::RoboclawBoard(const Settings& settings)
    : settings_(settings), printer_(settings.address), answers_(settings.address) {
  const ByteView stop = printer_.duties(0, 0);
  std::copy(stop.begin(), stop.end(), stop_frame_.begin());
}

double RoboclawBoard::max_wheel_rate() const {
  return static_cast<double>(INT32_MAX) * settings_.wiring.rad_per_count();
}

double RoboclawBoard::position_wrap_rad() const { return 4294967296.0 * settings_.wiring.rad_per_count(); }

void RoboclawBoard::restart() {
  answers_.fall_out_of_step();
  next_ = Question::Timeout;
}

ByteView RoboclawBoard::speed_frame(const WheelRates& rates) {
  const BaseWiring& wiring = settings_.wiring;
  const auto counts = [](double cps) { return static_cast<std::int32_t>(std::lround(cps)); };
  const std::int32_t left = counts(wiring.counts_per_s(wiring.left, rates.left_rps));
  const std::int32_t right = counts(wiring.counts_per_s(wiring.right, rates.right_rps));
  const bool is_left_first = wiring.left.channel == 1;
  return printer_.speeds(is_left_first ? left : right, is_left_first ? right : left);
}

void RoboclawBoard::expect(RoboclawCommand command, MonotonicTime now) {
  if (answers_.awaited() == 0) awaits_since_ = now;
  answers_.expect(command);
  active_at_ = now;
}

void RoboclawBoard::give_up_the_missing(MonotonicTime now) {
  // Lost on the way, or the board was off and has forgotten its timeout.
  if (answers_.awaited() > 0 && now - awaits_since_ > kAnsweredWithin) restart();
}

void RoboclawBoard::on_commanded(MonotonicTime now, const WheelRates&) {
  give_up_the_missing(now);
  expect(RoboclawCommand::Speed, now);  // a stop is answered in the same way
}

ByteView RoboclawBoard::ask(RoboclawCommand command, MonotonicTime now) {
  expect(command, now);
  return printer_.read(command);
}

ByteView RoboclawBoard::next_request(MonotonicTime now) {
  give_up_the_missing(now);
  if (answers_.awaited() > 0) return {};
  const bool is_quiet = now - active_at_ > kAnsweredWithin;
  if (!answers_.is_in_step()) {
    if (!is_quiet) return {};
    answers_.assume_step();
  }
  if (next_ == Question::None) {
    if (now - round_at_ < settings_.request_period) return {};
    next_ = Question::SpeedM1;
  }
  if (next_ == Question::Timeout && settings_.motor_watchdog.count() <= 0) next_ = Question::SpeedM1;
  if (next_ == Question::Battery && now - battery_at_ < kBatteryPeriod) {
    next_ = Question::None;
    return {};
  }
  switch (next_) {
    case Question::Timeout: {
      expect(RoboclawCommand::SerialTimeout, now);
      const auto tenths = (settings_.motor_watchdog.count() + 99) / 100;
      return printer_.serial_timeout(static_cast<std::uint8_t>(std::min<std::int64_t>(tenths, 255)));
    }
    case Question::SpeedM1: round_at_ = now; return ask(RoboclawCommand::SpeedM1, now);
    case Question::SpeedM2: return ask(RoboclawCommand::SpeedM2, now);
    case Question::Encoders: return ask(RoboclawCommand::Encoders, now);
    case Question::Status: return ask(RoboclawCommand::Status, now);
    case Question::Battery: battery_at_ = now; return ask(RoboclawCommand::MainBattery, now);
    case Question::None: break;
  }
  return {};
}

void RoboclawBoard::feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) {
  active_at_ = received_at;
  const std::uint64_t losses = answers_.stats().losses;
  answers_.feed(bytes, [&](const RoboclawAnswer& answer) {
    awaits_since_ = received_at;
    take(answer, ears);
  });
  // Out of step: the round begins anew, so that speeds and encoders of one state belong together.
  if (answers_.stats().losses != losses && next_ != Question::Timeout) next_ = Question::SpeedM1;
}

void RoboclawBoard::take(const RoboclawAnswer& answer, BoardEars& ears) {
  const BaseWiring& wiring = settings_.wiring;
  switch (answer.command) {
    case RoboclawCommand::SerialTimeout: next_ = Question::SpeedM1; break;
    case RoboclawCommand::SpeedM1:
      speeds_cps_[0] = answer.value;
      next_ = Question::SpeedM2;
      break;
    case RoboclawCommand::SpeedM2:
      speeds_cps_[1] = answer.value;
      next_ = Question::Encoders;
      break;
    case RoboclawCommand::Encoders: {
      next_ = Question::Status;
      const bool is_left_first = wiring.left.channel == 1;
      const std::array<std::int32_t, 2> counts{answer.value, answer.second};
      const std::size_t left = is_left_first ? 0 : 1;
      const std::size_t right = 1 - left;
      ears.on_wheels({{wiring.rad(wiring.left, speeds_cps_[left]), wiring.rad(wiring.right, speeds_cps_[right])},
                      true,
                      wiring.rad(wiring.left, counts[left]),
                      wiring.rad(wiring.right, counts[right])},
                     answer.first_byte);
      break;
    }
    case RoboclawCommand::Status:
      next_ = Question::Battery;
      ears.on_fault(roboclaw_fault(static_cast<std::uint32_t>(answer.value), answer.is_old_layout));
      break;
    case RoboclawCommand::MainBattery:
      next_ = Question::None;
      ears.on_voltage(0.1 * answer.value);
      break;
    default: break;
  }
}

}  // namespace nacelle::diff_drive
