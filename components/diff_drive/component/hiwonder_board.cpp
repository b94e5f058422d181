// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/hiwonder_board.hpp"

#include <algorithm>

namespace nacelle::diff_drive {

HiwonderBoard::HiwonderBoard(const Settings& settings)
    : settings_(settings), printer_(settings.wiring.left.channel, settings.wiring.right.channel) {
  const ByteView stop = printer_.speeds(0.0F, 0.0F);
  std::copy(stop.begin(), stop.end(), stop_frame_.begin());
}

// The wheels' angles go on: the board has none that could begin anew.
void HiwonderBoard::restart() {
  decoder_.restart();
  heard_at_.reset();
  stated_at_.reset();
  turned_until_.reset();
  rates_ = {};
}

void HiwonderBoard::feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) {
  decoder_.feed(bytes, [&](const HiwonderReport& report) {
    heard_at_ = received_at;
    if (report.battery_mv) ears.on_voltage(0.001 * *report.battery_mv);
  });
}

void HiwonderBoard::assume_wheels(MonotonicTime now, BoardEars& ears) {
  if (!heard_at_ || now - *heard_at_ > kReportsWithin) return;
  if (stated_at_ && now - *stated_at_ < settings_.state_period) return;
  stated_at_ = now;
  turn_wheels_until(now);
  ears.on_wheels({rates_, true, left_rad_, right_rad_}, decoder_.stats().bytes);
}

ByteView HiwonderBoard::speed_frame(const WheelRates& rates) {
  const BaseWiring& wiring = settings_.wiring;
  return printer_.speeds(static_cast<float>(wiring.counts_per_s(wiring.left, rates.left_rps)),
                         static_cast<float>(wiring.counts_per_s(wiring.right, rates.right_rps)));
}

void HiwonderBoard::on_commanded(MonotonicTime now, const WheelRates& rates) {
  turn_wheels_until(now);
  rates_ = rates;
}

void HiwonderBoard::turn_wheels_until(MonotonicTime now) {
  if (turned_until_) {
    const double elapsed_s = to_seconds(now - *turned_until_);
    left_rad_ += rates_.left_rps * elapsed_s;
    right_rad_ += rates_.right_rps * elapsed_s;
  }
  turned_until_ = now;
}

}  // namespace nacelle::diff_drive
