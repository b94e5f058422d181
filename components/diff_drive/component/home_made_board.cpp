// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/home_made_board.hpp"

#include <algorithm>

namespace nacelle::diff_drive {
namespace {

constexpr std::string_view kTextStop = "M 0 0\n";

std::uint16_t milliseconds_of(std::chrono::milliseconds length) {
  return static_cast<std::uint16_t>(std::clamp<std::int64_t>(length.count(), 0, 60000));
}

double with_sign(const WheelWiring& wheel, double rate_rps) { return wheel.is_reversed ? -rate_rps : rate_rps; }

}  // namespace

FramedBoard::FramedBoard(const HomeMadeSettings& settings) : settings_(settings) {
  const ByteView stop = printer_.stop();
  std::copy(stop.begin(), stop.end(), stop_frame_.begin());
}

ByteView FramedBoard::speed_frame(const WheelRates& rates) {
  return printer_.speeds(static_cast<float>(with_sign(settings_.wiring.left, rates.left_rps)),
                         static_cast<float>(with_sign(settings_.wiring.right, rates.right_rps)));
}

ByteView FramedBoard::setup_frame(std::size_t index) {
  if (index != 0) return {};
  return printer_.settings(milliseconds_of(settings_.motor_watchdog), milliseconds_of(settings_.state_period));
}

void FramedBoard::feed(ByteView bytes, MonotonicTime, BoardEars& ears) {
  decoder_.feed(bytes, [&](const MotorFrameState& state) {
    const BaseWiring& wiring = settings_.wiring;
    if (state.battery_mv != 0) ears.on_voltage(0.001 * state.battery_mv);
    ears.on_fault(motor_frame_fault(state.faults));
    ears.on_wheels({{with_sign(wiring.left, state.left_rps), with_sign(wiring.right, state.right_rps)},
                    true,
                    wiring.rad(wiring.left, state.left_counts),
                    wiring.rad(wiring.right, state.right_counts)},
                   state.first_byte);
  });
}

void TextBoard::restart() {
  decoder_.restart();
  last_.reset();
  rates_ = {};
}

ByteView TextBoard::stop_frame() const { return as_bytes(kTextStop); }

ByteView TextBoard::speed_frame(const WheelRates& rates) {
  commands_.clear();
  return commands_.text("M ")
      .decimal(with_sign(settings_.wiring.left, rates.left_rps))
      .text(" ")
      .decimal(with_sign(settings_.wiring.right, rates.right_rps))
      .end()
      .lines();
}

ByteView TextBoard::setup_frame(std::size_t index) {
  if (index != 0 || settings_.motor_watchdog.count() <= 0) return {};
  commands_.clear();
  return commands_.text("W ").integer(milliseconds_of(settings_.motor_watchdog)).end().lines();
}

void TextBoard::feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) {
  decoder_.feed(
      bytes, [&](const NumberLine& line) { take(line, received_at, ears); }, [] {});
}

void TextBoard::take(const NumberLine& line, MonotonicTime received_at, BoardEars& ears) {
  const BaseWiring& wiring = settings_.wiring;
  if (line.word == "B" && line.count == 1) return ears.on_voltage(line.numbers[0]);
  if (line.word == "F" && line.count == 1) {
    const bool is_known = line.numbers[0] >= 0.0 && line.numbers[0] <= 65535.0;
    return ears.on_fault(motor_frame_fault(is_known ? static_cast<std::uint16_t>(line.numbers[0]) : 0x8000));
  }
  if (line.word != "E" || (line.count != 2 && line.count != 4)) return;
  const Counts now{received_at, line.numbers[0], line.numbers[1]};
  if (line.count == 4) {
    rates_ = {with_sign(wiring.left, line.numbers[2]), with_sign(wiring.right, line.numbers[3])};
  } else if (last_ && received_at > last_->at) {
    const double elapsed_s = to_seconds(received_at - last_->at);
    rates_ = {wiring.rad(wiring.left, now.left - last_->left) / elapsed_s,
              wiring.rad(wiring.right, now.right - last_->right) / elapsed_s};
  }
  // Of several lines in one chunk the last counts: they came at one time, and were sent at others.
  if (!last_ || received_at > last_->at) last_ = now;
  ears.on_wheels({rates_, true, wiring.rad(wiring.left, now.left), wiring.rad(wiring.right, now.right)},
                 line.first_byte);
}

MotorBoard::Stats TextBoard::stats() const {
  const NumberLineDecoder::Stats& seen = decoder_.stats();
  return {seen.bytes, seen.malformed_bytes + seen.overlong_bytes};
}

}  // namespace nacelle::diff_drive
