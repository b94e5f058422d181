// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/vesc_board.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {
namespace {

// Steps of the tachometer per second to electrical turns per minute: 60 s over 6 steps.
constexpr double kErpmPerStep = 10.0;

}  // namespace

VescBoard::VescBoard(const Settings& settings)
    : settings_(settings), printer_(settings.wiring.left.channel, settings.wiring.right.channel) {
  const ByteView stop = printer_.zero_duties();
  std::copy(stop.begin(), stop.end(), stop_frame_.begin());
  stop_bytes_ = stop.size();
}

double VescBoard::max_wheel_rate() const {
  return static_cast<double>(INT32_MAX) / kErpmPerStep * settings_.wiring.rad_per_count();
}

double VescBoard::position_wrap_rad() const { return 4294967296.0 * settings_.wiring.rad_per_count(); }

void VescBoard::restart() {
  decoder_.restart();
  heard_ = {};
  faults_ = {};
  asked_at_ = {};
}

ByteView VescBoard::speed_frame(const WheelRates& rates) {
  const BaseWiring& wiring = settings_.wiring;
  const auto erpm = [&](const WheelWiring& wheel, double rate_rps) {
    return static_cast<std::int32_t>(std::lround(kErpmPerStep * wiring.counts_per_s(wheel, rate_rps)));
  };
  return printer_.speeds(erpm(wiring.left, rates.left_rps), erpm(wiring.right, rates.right_rps));
}

ByteView VescBoard::next_request(MonotonicTime now) {
  if (now - asked_at_ < settings_.request_period) return {};
  asked_at_ = now;
  return printer_.get_values();
}

std::optional<std::size_t> VescBoard::wheel_of(std::uint8_t id) const {
  const int left = settings_.wiring.left.channel;
  const int right = settings_.wiring.right.channel;
  if (id == left) return 0;
  if (id == right) return 1;
  // The one on the line was asked without an id, and has one nevertheless.
  if (left == VescPrinter::kOnTheLine) return 0;
  if (right == VescPrinter::kOnTheLine) return 1;
  return std::nullopt;
}

void VescBoard::feed(ByteView bytes, MonotonicTime, BoardEars& ears) {
  decoder_.feed(bytes, [&](const VescValues& values) { take(values, ears); });
}

void VescBoard::take(const VescValues& values, BoardEars& ears) {
  const auto wheel = wheel_of(values.id);
  if (!wheel) return;
  heard_[*wheel] = values;
  faults_[*wheel] = values.fault;
  ears.on_fault(faults_[0] != 0 ? vesc_fault(faults_[0], true) : vesc_fault(faults_[1], false));
  if (!heard_[0] || !heard_[1]) return;
  const BaseWiring& wiring = settings_.wiring;
  const auto rate = [&](const WheelWiring& side, const VescValues& of) {
    return wiring.rad(side, of.erpm / kErpmPerStep);
  };
  ears.on_voltage(values.voltage_v);
  ears.on_wheels({{rate(wiring.left, *heard_[0]), rate(wiring.right, *heard_[1])},
                  true,
                  wiring.rad(wiring.left, heard_[0]->tachometer),
                  wiring.rad(wiring.right, heard_[1]->tachometer)},
                 values.first_byte);
  heard_ = {};
}

}  // namespace nacelle::diff_drive
