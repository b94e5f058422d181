// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/odrive_can_board.hpp"

namespace nacelle::diff_drive {
namespace {

// source: AXIS_STATE_CLOSED_LOOP_CONTROL, CONTROL_MODE_VELOCITY_CONTROL, INPUT_MODE_PASSTHROUGH
constexpr std::uint32_t kStateClosedLoop = 8, kControlVelocity = 2, kInputPassthrough = 1;
constexpr Duration kSettledWithin = 250ms;  // two heartbeats, and their way
constexpr Duration kBeatsWithin = 1s;       // ten heartbeats
constexpr Duration kCyclicWithin = 30ms;    // three estimates
constexpr Duration kVoltagePeriod = 1s;

constexpr const char* kAxisErrors[] = {"left ODrive axis: an error; `odrivetool` and dump_errors(odrv0) name it",
                                       "right ODrive axis: an error; `odrivetool` and dump_errors(odrv0) name it"};
constexpr const char* kAxisNotRunning[] = {
    "left ODrive axis: not in closed loop control; is it calibrated? activate the base again",
    "right ODrive axis: not in closed loop control; is it calibrated? activate the base again"};
constexpr const char* kNoBeat[] = {"left ODrive axis: no heartbeat; set its heartbeat rate to 100 ms",
                                   "right ODrive axis: no heartbeat; set its heartbeat rate to 100 ms"};

}  // namespace

OdriveCanBoard::OdriveCanBoard(const Settings& settings) : settings_(settings) {
  for (std::size_t wheel = 0; wheel < 2; ++wheel) stop_.add(odrive_set_velocity(node(wheel), 0.0));
}

int OdriveCanBoard::node(std::size_t wheel) const {
  return wheel == 0 ? settings_.wiring.left.channel : settings_.wiring.right.channel;
}

std::optional<std::size_t> OdriveCanBoard::wheel_of(int sender) const {
  if (sender == node(0)) return 0;
  if (sender == node(1)) return 1;
  return std::nullopt;
}

void OdriveCanBoard::restart() {
  decoder_.restart();
  pairing_.restart();
  axes_ = {};
  settled_at_.reset();
  asked_at_ = voltage_asked_at_ = {};
}

ByteView OdriveCanBoard::speed_frame(const WheelRates& rates) {
  const BaseWiring& wiring = settings_.wiring;
  commands_.clear();
  return commands_.add(odrive_set_velocity(node(0), wiring.counts_per_s(wiring.left, rates.left_rps)))
      .add(odrive_set_velocity(node(1), wiring.counts_per_s(wiring.right, rates.right_rps)))
      .bytes();
}

ByteView OdriveCanBoard::setup_frame(std::size_t index) {
  commands_.clear();
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    if (index == 0) commands_.add(odrive_clear_errors(node(wheel)));
    if (index == 1) commands_.add(odrive_set_modes(node(wheel), kControlVelocity, kInputPassthrough));
    if (index == 2) commands_.add(odrive_set_axis_state(node(wheel), kStateClosedLoop));
  }
  return commands_.bytes();
}

void OdriveCanBoard::on_commanded(MonotonicTime now, const WheelRates&) {
  if (settled_at_) return;
  settled_at_ = now + kSettledWithin;
  for (Axis& axis : axes_) axis.beat_at = now;
}

bool OdriveCanBoard::must_be_asked(Axis& axis, MonotonicTime now) {
  // More than the answer came since the last question: it sends them by itself.
  axis.is_asked = axis.is_asked ? axis.heard_since_asked < 2 : now - axis.moved_at > kCyclicWithin;
  axis.heard_since_asked = 0;
  return axis.is_asked;
}

ByteView OdriveCanBoard::next_request(MonotonicTime now) {
  if (now - asked_at_ < settings_.request_period) return {};
  asked_at_ = now;
  requests_.clear();
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    if (must_be_asked(axes_[wheel], now)) requests_.add(odrive_request(node(wheel), OdriveCommand::EncoderEstimates));
  }
  if (now - voltage_asked_at_ >= kVoltagePeriod) {
    voltage_asked_at_ = now;
    requests_.add(odrive_request(node(0), OdriveCommand::BusVoltage));
  }
  return requests_.bytes();
}

void OdriveCanBoard::feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) {
  decoder_.feed(bytes, [&](const OdriveReport& report, std::uint64_t first_byte) {
    if (const auto* const beat = std::get_if<OdriveHeartbeat>(&report)) {
      take(*beat, received_at);
      tell_fault(received_at, ears);
    } else if (const auto* const voltage = std::get_if<OdriveVoltage>(&report)) {
      if (voltage->node == node(0)) ears.on_voltage(voltage->voltage_v);
    } else if (const auto* const motion = std::get_if<OdriveMotion>(&report); take(*motion, received_at)) {
      tell_fault(received_at, ears);
      const BaseWiring& wiring = settings_.wiring;
      const OdriveMotion &left = axes_[0].motion, &right = axes_[1].motion;
      ears.on_wheels({{wiring.rad(wiring.left, left.velocity_tps), wiring.rad(wiring.right, right.velocity_tps)},
                      true,
                      wiring.rad(wiring.left, left.position_t),
                      wiring.rad(wiring.right, right.position_t)},
                     first_byte);
    }
  });
}

void OdriveCanBoard::take(const OdriveHeartbeat& beat, MonotonicTime at) {
  const auto wheel = wheel_of(beat.node);
  if (!wheel) return;
  Axis& axis = axes_[*wheel];
  axis.beat_at = at;
  const bool is_fault = beat.axis_error != 0 || beat.axis_state != kStateClosedLoop;
  if (is_fault && !is_settled(at)) return;
  axis.error = beat.axis_error;
  axis.state = beat.axis_state;
}

bool OdriveCanBoard::take(const OdriveMotion& motion, MonotonicTime at) {
  const auto wheel = wheel_of(motion.node);
  if (!wheel) return false;
  axes_[*wheel].motion = motion;
  ++axes_[*wheel].heard_since_asked;
  axes_[*wheel].moved_at = at;
  return pairing_.hear(*wheel, at);
}

void OdriveCanBoard::tell_fault(MonotonicTime now, BoardEars& ears) const {
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    if (axes_[wheel].error != 0) return ears.on_fault(kAxisErrors[wheel]);
  }
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    const Axis& axis = axes_[wheel];
    if (axis.state && *axis.state != kStateClosedLoop) return ears.on_fault(kAxisNotRunning[wheel]);
    if (is_settled(now) && now - axis.beat_at > kBeatsWithin) return ears.on_fault(kNoBeat[wheel]);
  }
  ears.on_fault(nullptr);
}

}  // namespace nacelle::diff_drive
