// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/odrive_can_device.hpp"

#include <cstring>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr double kRadPerRevolution = 2.0 * std::numbers::pi;
constexpr std::uint32_t kErrorWatchdog = 0x800;  // source: AXIS_ERROR_WATCHDOG_TIMER_EXPIRED, 0.5

template <typename T>
void push(Bytes& data, T value) {
  std::array<std::uint8_t, sizeof value> raw{};
  std::memcpy(raw.data(), &value, sizeof value);
  for (const std::uint8_t byte : raw) data.push_back(byte);
}
// Signals behind the end of a short frame read as zero: the firmware's receive buffer begins cleared.
template <typename T>
T pull(const Bytes& data, std::size_t at) {
  T value{};
  if (at + sizeof value <= data.size()) std::memcpy(&value, data.data() + at, sizeof value);
  return value;
}

}  // namespace

OdriveCanDevice::OdriveCanDevice(const Settings& settings) : settings_(settings) {
  for (std::size_t i = 0; i < 2; ++i) axes_[i].estimated = settings.phases[i];
}

void OdriveCanDevice::send(std::size_t index, std::uint32_t command, Bytes data, Bytes& bytes) const {
  if (!axes_[index].is_silent) append(bytes, {settings_.nodes[index] * 32 + command, false, false, std::move(data)});
}

void OdriveCanDevice::send_estimates(std::size_t index, Bytes& bytes) const {
  Bytes data;
  push(data, axes_[index].position_t);
  push(data, axes_[index].velocity_tps);
  send(index, 0x09, std::move(data), bytes);
}

Bytes OdriveCanDevice::on_bytes(ByteView bytes, Duration now) {
  Bytes answers;
  for (const CanMessage& message : wire_.cut(bytes)) {
    for (std::size_t i = 0; i < 2; ++i) {
      if (!message.is_long && message.id / 32 == settings_.nodes[i] && !axes_[i].is_silent)
        obey(i, message.id % 32, message, now, answers);
    }
  }
  return answers;
}

void OdriveCanDevice::obey(std::size_t index, std::uint32_t command, const CanMessage& message, Duration now,
                           Bytes& answers) {
  Axis& axis = axes_[index];
  axis.fed = now;
  if (message.is_remote) {
    if (command == 0x09) send_estimates(index, answers);
    if (command == 0x17) {
      Bytes data;
      push(data, volts_);
      push(data, 0.5F);
      send(index, command, std::move(data), answers);
    }
    return;
  }
  switch (command) {
    case 0x02: axis.error |= 0x4000; break;  // source: AXIS_ERROR_ESTOP_REQUESTED
    case 0x07: {
      const auto wanted = pull<std::uint32_t>(message.data, 0);
      const bool can_run = wanted != 8 || (axis.is_calibrated && axis.error == 0);
      axis.state = static_cast<std::uint8_t>(can_run ? wanted : 1);
      break;
    }
    case 0x0B:
      axis.control_mode = pull<std::uint32_t>(message.data, 0);
      axis.input_mode = pull<std::uint32_t>(message.data, 4);
      break;
    case 0x0D: axis.target_tps = pull<float>(message.data, 0); break;
    case 0x18:
      for (Axis& each : axes_) each.error = 0;  // odrv.clear_errors() is the whole board's
      break;
    default: break;
  }
}

double OdriveCanDevice::target_rps(std::size_t index) const {
  const Axis& axis = axes_[index];
  return axis.state == 8 && axis.control_mode == 2 && axis.input_mode == 1 ? axis.target_tps * kRadPerRevolution : 0.0;
}

Bytes OdriveCanDevice::step(Duration now, double left_angle_rad, double right_angle_rad) {
  const std::array<double, 2> turns{left_angle_rad / kRadPerRevolution, right_angle_rad / kRadPerRevolution};
  const double elapsed_s = to_seconds(now - stepped_);
  Bytes bytes;
  for (std::size_t i = 0; i < 2; ++i) {
    Axis& axis = axes_[i];
    if (elapsed_s > 0.0) axis.velocity_tps = static_cast<float>((turns[i] - turns_[i]) / elapsed_s);
    axis.position_t = static_cast<float>(turns[i]);
    if (settings_.watchdog_s > 0.0 && axis.state == 8 && to_seconds(now - axis.fed) > settings_.watchdog_s)
      axis.error |= kErrorWatchdog;
    if (axis.error != 0) axis.state = 1;
    if (settings_.estimates[i] > Duration::zero() && now - axis.estimated >= settings_.estimates[i]) {
      axis.estimated += (now - axis.estimated) / settings_.estimates[i] * settings_.estimates[i];
      send_estimates(i, bytes);
    }
    if (settings_.heartbeat > Duration::zero() && now - axis.beaten >= settings_.heartbeat) {
      axis.beaten = now;
      ++axis.beats;
      Bytes data;
      push(data, axis.error);
      data.insert(data.end(), {axis.state, 0, 0, 0});
      send(i, 0x01, std::move(data), bytes);
    }
  }
  turns_ = turns;
  stepped_ = now;
  return bytes;
}

}  // namespace nacelle::simulation
