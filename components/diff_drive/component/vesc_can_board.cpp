// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/vesc_can_board.hpp"

#include <cmath>
#include <utility>

#include "diff_drive/protocol/vesc_frame.hpp"

namespace nacelle::diff_drive {
namespace {

// Steps of the tachometer per second to electrical turns per minute: 60 s over 6 steps.
constexpr double kErpmPerCount = 10.0;
constexpr Duration kFaultPeriod = 100ms;

}  // namespace

VescCanBoard::VescCanBoard(const Settings& settings) : settings_(settings) {
  for (std::size_t wheel = 0; wheel < 2; ++wheel) stop_.add(vesc_zero_duty(id(wheel)));
}

std::uint8_t VescCanBoard::id(std::size_t wheel) const {
  return static_cast<std::uint8_t>(wheel == 0 ? settings_.wiring.left.channel : settings_.wiring.right.channel);
}

std::optional<std::size_t> VescCanBoard::wheel_of(std::uint8_t sender) const {
  if (sender == id(0)) return 0;
  if (sender == id(1)) return 1;
  return std::nullopt;
}

double VescCanBoard::max_wheel_rate() const {
  return static_cast<double>(INT32_MAX) / kErpmPerCount * settings_.wiring.rad_per_count();
}

double VescCanBoard::position_wrap_rad() const { return 4294967296.0 * settings_.wiring.rad_per_count(); }

void VescCanBoard::restart() {
  decoder_.restart();
  pairing_.restart();
  wheels_ = {};
  asked_at_ = {};
}

ByteView VescCanBoard::speed_frame(const WheelRates& rates) {
  const BaseWiring& wiring = settings_.wiring;
  const auto erpm = [&](const WheelWiring& wheel, double rate_rps) {
    return static_cast<std::int32_t>(std::lround(kErpmPerCount * wiring.counts_per_s(wheel, rate_rps)));
  };
  commands_.clear();
  return commands_.add(vesc_set_rpm(id(0), erpm(wiring.left, rates.left_rps)))
      .add(vesc_set_rpm(id(1), erpm(wiring.right, rates.right_rps)))
      .bytes();
}

ByteView VescCanBoard::next_request(MonotonicTime now) {
  if (now - asked_at_ < kFaultPeriod) return {};
  asked_at_ = now;
  requests_.clear();
  return requests_.add(vesc_ask_fault(id(0))).add(vesc_ask_fault(id(1))).bytes();
}

void VescCanBoard::feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) {
  decoder_.feed(bytes, [&](const VescReport& report, std::uint64_t first_byte) {
    if (const auto* const speed = std::get_if<VescSpeed>(&report)) {
      if (const auto wheel = wheel_of(speed->id)) wheels_[*wheel].erpm = speed->erpm;
    } else if (const auto* const fault = std::get_if<VescFaultReport>(&report)) {
      const auto wheel = wheel_of(fault->id);
      if (!wheel) return;
      wheels_[*wheel].fault = fault->fault;
      ears.on_fault(wheels_[0].fault != 0 ? vesc_fault(wheels_[0].fault, true) : vesc_fault(wheels_[1].fault, false));
    } else if (const auto* const travel = std::get_if<VescTravel>(&report); take(*travel, received_at)) {
      const BaseWiring& wiring = settings_.wiring;
      const Wheel &left = wheels_[0], &right = wheels_[1];
      ears.on_voltage(travel->voltage_v);
      ears.on_wheels({{wiring.rad(wiring.left, left.travelled_erpm / kErpmPerCount),
                       wiring.rad(wiring.right, right.travelled_erpm / kErpmPerCount)},
                      true,
                      wiring.rad(wiring.left, left.travel.tachometer),
                      wiring.rad(wiring.right, right.travel.tachometer)},
                     first_byte);
    }
  });
}

// A VESC sends its speed before its travel. A travel whose speed was lost counts as lost, too.
bool VescCanBoard::take(const VescTravel& travel, MonotonicTime at) {
  const auto number = wheel_of(travel.id);
  if (!number) return false;
  Wheel& wheel = wheels_[*number];
  const auto erpm = std::exchange(wheel.erpm, std::nullopt);
  if (!erpm) return false;
  wheel.travel = travel;
  wheel.travelled_erpm = *erpm;
  return pairing_.hear(*number, at);
}

}  // namespace nacelle::diff_drive
