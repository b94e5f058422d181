// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/odrive_board.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr double kClosedLoopControl = 8.0;             // source: AXIS_STATE_CLOSED_LOOP_CONTROL
constexpr int kVelocityControl = 2, kPassthrough = 1;  // source: CONTROL_MODE_VELOCITY_CONTROL, INPUT_MODE_PASSTHROUGH

constexpr const char* kErrors[] = {"left ODrive axis: an error; `odrivetool` and dump_errors(odrv0) name it",
                                   "right ODrive axis: an error; `odrivetool` and dump_errors(odrv0) name it"};
constexpr const char* kNotRunning[] = {
    "left ODrive axis: not in closed loop control; is it calibrated? activate the base again",
    "right ODrive axis: not in closed loop control; is it calibrated? activate the base again"};

}  // namespace

OdriveBoard::OdriveBoard(const Settings& settings) : settings_(settings) {
  for (std::size_t wheel = 0; wheel < 2; ++wheel) stop_.text("v ").integer(axis(wheel)).text(" 0").end_checked();
}

int OdriveBoard::axis(std::size_t wheel) const {
  return wheel == 0 ? settings_.wiring.left.channel : settings_.wiring.right.channel;
}

void OdriveBoard::restart() {
  decoder_.restart();
  awaits_ = false;
  next_ = Question::LeftMotion;
  round_at_ = {};
  has_state_ = {};
  errors_ = {};
}

ByteView OdriveBoard::speed_frame(const WheelRates& rates) {
  const BaseWiring& wiring = settings_.wiring;
  commands_.clear();
  commands_.text("v ")
      .integer(axis(0))
      .text(" ")
      .decimal(wiring.counts_per_s(wiring.left, rates.left_rps))
      .end_checked();
  commands_.text("v ")
      .integer(axis(1))
      .text(" ")
      .decimal(wiring.counts_per_s(wiring.right, rates.right_rps))
      .end_checked();
  return commands_.lines();
}

ByteView OdriveBoard::setup_frame(std::size_t index) {
  const auto write_both = [this](std::string_view property) -> NumberLinePrinter& {
    commands_.clear();
    for (std::size_t wheel = 0; wheel < 2; ++wheel)
      commands_.text("w axis").integer(axis(wheel)).text(property).end_checked();
    return commands_;
  };
  switch (index) {
    // An armed watchdog would make a new error before the rest is done. The order is that of ODrive's own test of it.
    case 0: return write_both(".config.enable_watchdog 0").text("sc").end_checked().lines();
    case 1: {
      commands_.clear();
      for (std::size_t wheel = 0; wheel < 2; ++wheel) {
        commands_.text("w axis")
            .integer(axis(wheel))
            .text(".controller.config.control_mode ")
            .integer(kVelocityControl)
            .end_checked();
        commands_.text("w axis")
            .integer(axis(wheel))
            .text(".controller.config.input_mode ")
            .integer(kPassthrough)
            .end_checked();
      }
      return commands_.lines();
    }
    case 2: {
      commands_.clear();
      for (std::size_t wheel = 0; wheel < 2; ++wheel) {
        commands_.text("w axis").integer(axis(wheel)).text(".config.watchdog_timeout ");
        commands_.decimal(0.001 * static_cast<double>(settings_.motor_watchdog.count())).end_checked();
      }
      return commands_.lines();
    }
    case 3: {
      commands_.clear();
      for (std::size_t wheel = 0; wheel < 2; ++wheel) commands_.text("u ").integer(axis(wheel)).end_checked();
      return commands_.lines();
    }
    case 4:
      return write_both(settings_.motor_watchdog.count() > 0 ? ".config.enable_watchdog 1"
                                                             : ".config.enable_watchdog 0")
          .lines();
    case 5: return write_both(".requested_state 8").lines();
    default: return {};
  }
}

ByteView OdriveBoard::separator() const { return kLineEnd; }

ByteView OdriveBoard::next_request(MonotonicTime now) {
  if (awaits_) {
    if (now - asked_at_ < kAnsweredWithin) return {};
    // A late answer must not be taken for that of the next question: nothing is asked for as long again.
    awaits_ = false;
    next_ = Question::LeftMotion;
    silent_until_ = now + kAnsweredWithin;
    has_state_ = {};
  }
  if (now < silent_until_) return {};
  if (next_ == Question::None) {
    if (now - round_at_ < settings_.request_period) return {};
    next_ = Question::LeftMotion;
  }
  if (next_ == Question::LeftMotion) round_at_ = now;
  question_.clear();
  if (next_ != Question::Slow) {
    question_.text("f ").integer(axis(next_ == Question::LeftMotion ? 0 : 1));
  } else if (slow_ < 2) {
    question_.text("r axis").integer(axis(slow_)).text(".error");
  } else if (slow_ < 4) {
    question_.text("r axis").integer(axis(slow_ - 2)).text(".current_state");
  } else {
    question_.text("r vbus_voltage");
  }
  awaits_ = true;
  asked_at_ = now;
  return question_.end_checked().lines();
}

void OdriveBoard::go_on() {
  awaits_ = false;
  switch (next_) {
    case Question::LeftMotion: next_ = Question::RightMotion; break;
    case Question::RightMotion: next_ = Question::Slow; break;
    default: next_ = Question::None; slow_ = (slow_ + 1) % kSlowQuestions;
  }
}

void OdriveBoard::feed(ByteView bytes, MonotonicTime, BoardEars& ears) {
  decoder_.feed(
      bytes, [&](const NumberLine& line) { take(line, ears); },
      [&] {
        if (!awaits_) return;
        // "invalid property" of another firmware, or a damaged line: the question is given up, a motion is asked for anew.
        if (next_ == Question::Slow) return go_on();
        awaits_ = false;
        next_ = Question::LeftMotion;
      });
}

void OdriveBoard::take(const NumberLine& line, BoardEars& ears) {
  if (!awaits_ || !line.word.empty()) return;
  if (next_ == Question::Slow) {
    if (line.count != 1) return;
    take_slow(line.numbers[0], ears);
    return go_on();
  }
  if (line.count != 2) return;
  if (next_ == Question::LeftMotion) {
    left_motion_ = {line.numbers[0], line.numbers[1]};
  } else {
    const BaseWiring& wiring = settings_.wiring;
    ears.on_wheels({{wiring.rad(wiring.left, left_motion_[1]), wiring.rad(wiring.right, line.numbers[1])},
                    true,
                    wiring.rad(wiring.left, left_motion_[0]),
                    wiring.rad(wiring.right, line.numbers[0])},
                   line.first_byte);
  }
  go_on();
}

void OdriveBoard::take_slow(double value, BoardEars& ears) {
  if (slow_ == kSlowQuestions - 1) return ears.on_voltage(value);
  if (slow_ < 2) {
    errors_[slow_] = value;
  } else {
    states_[slow_ - 2] = value;
    has_state_[slow_ - 2] = true;
  }
  tell_fault(ears);
}

void OdriveBoard::tell_fault(BoardEars& ears) const {
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    if (errors_[wheel] != 0.0) return ears.on_fault(kErrors[wheel]);
  }
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    if (has_state_[wheel] && states_[wheel] != kClosedLoopControl) return ears.on_fault(kNotRunning[wheel]);
  }
  ears.on_fault(nullptr);
}

MotorBoard::Stats OdriveBoard::stats() const {
  const NumberLineDecoder::Stats& seen = decoder_.stats();
  return {seen.bytes, seen.malformed_bytes + seen.overlong_bytes};
}

}  // namespace nacelle::diff_drive
