// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/waveshare_board.hpp"

#include <algorithm>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {
WaveshareBoard::WaveshareBoard(Settings settings) : settings_(settings) {
  NACELLE_EXPECT(settings.wheel_radius_m > 0.0, "a wheel has a radius");
}

void WaveshareBoard::feed(ByteView bytes, MonotonicTime, BoardEars& ears) {
  std::uint64_t told = decoder_.stats().feedback_bytes;
  decoder_.feed(bytes, [&](const BaseFeedback& feedback) {
    const WaveshareLineDecoder::Stats& seen = decoder_.stats();
    const std::uint64_t line_bytes = seen.feedback_bytes - std::exchange(told, seen.feedback_bytes);
    if (feedback.voltage_v) ears.on_voltage(*feedback.voltage_v);
    const double radius_m = settings_.wheel_radius_m;
    WheelReading reading{{feedback.left_mps / radius_m, feedback.right_mps / radius_m}};
    if (feedback.left_travel_m && feedback.right_travel_m) {
      reading.has_position = true;
      reading.left_rad = *feedback.left_travel_m / radius_m;
      reading.right_rad = *feedback.right_travel_m / radius_m;
    }
    ears.on_wheels(reading, seen.bytes - line_bytes);
  });
}

ByteView WaveshareBoard::speed_frame(const WheelRates& rates) {
  const auto rim_mps = [this](double rate_rps) {
    return std::clamp(rate_rps * settings_.wheel_radius_m, -kWaveshareMaxWheelSpeed_mps, kWaveshareMaxWheelSpeed_mps);
  };
  const auto frame = printer_.wheel_speeds(rim_mps(rates.left_rps), rim_mps(rates.right_rps));
  NACELLE_EXPECT(frame.has_value(), "rates of a speed frame are within max_wheel_rate()");
  return frame.value();
}

ByteView WaveshareBoard::setup_frame(std::size_t index) {
  switch (index) {
    case 0: return printer_.echo(false);
    case 1: return printer_.continuous_feedback(true);
    case 2:
      return settings_.motor_watchdog.count() > 0 ? printer_.motor_watchdog(settings_.motor_watchdog) : ByteView{};
    default: return {};
  }
}

// Ends the line that was begun; the board drops it as no JSON.
ByteView WaveshareBoard::separator() const { return kLineEnd; }

MotorBoard::Stats WaveshareBoard::stats() const {
  const WaveshareLineDecoder::Stats& seen = decoder_.stats();
  return {seen.bytes, seen.malformed_bytes + seen.overlong_bytes};
}

}  // namespace nacelle::diff_drive
