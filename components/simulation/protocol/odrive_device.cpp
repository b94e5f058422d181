// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/odrive_device.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <numbers>
#include <sstream>

namespace nacelle::simulation {
namespace {

constexpr double kRadPerTurn = 2.0 * std::numbers::pi;
constexpr std::uint32_t kWatchdogExpired = 0x800;  // source: AXIS_ERROR_WATCHDOG_TIMER_EXPIRED, 0.5

int xor_of(const std::string& text) {
  int sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return sum;
}

}  // namespace

Bytes OdriveDevice::on_bytes(ByteView bytes, Duration now) {
  std::string answers;
  for (const std::uint8_t byte : bytes) {
    if (byte != '\n') {
      line_.push_back(static_cast<char>(byte));
      continue;
    }
    std::string command = line_.substr(0, line_.find(';'));
    line_.clear();
    const std::size_t star = command.find('*');
    const bool is_checked = star != std::string::npos;
    if (is_checked && std::atoi(command.c_str() + star + 1) != xor_of(command.substr(0, star))) {
      ++bad_lines_;
      continue;
    }
    command.resize(is_checked ? star : command.size());
    std::string answer = obey(command, now);
    if (answer.empty()) continue;
    if (is_checked && settings_.answers_checksums) answer += fmt::format("*{}", xor_of(answer));
    answers += answer + "\r\n";
  }
  return {answers.begin(), answers.end()};
}

std::string OdriveDevice::obey(const std::string& command, Duration now) {
  std::istringstream words(command);
  std::string verb;
  words >> verb;
  if (verb == "v" || verb == "f" || verb == "u") {
    std::size_t index = 9;
    words >> index;
    if (index > 1) return "invalid motor " + std::to_string(index);
    Axis& axis = axes_[index];
    if (verb == "f") return fmt::format("{:.6f} {:.6f}", axis.position_t, axis.velocity_tps);
    axis.fed = now;
    if (verb == "v") {
      words >> axis.target_tps;
      axis.control_mode = 2;
    }
    return {};
  }
  if (verb == "sc") {
    for (Axis& axis : axes_) axis.error = 0;
    return {};
  }
  if (verb == "r" || verb == "w") {
    std::string property;
    double value = 0.0;
    words >> property >> value;
    return verb == "r" ? read(property) : write(property, value);
  }
  if (!verb.empty()) ++bad_lines_;
  return verb.empty() ? "" : "unknown command";
}

std::string OdriveDevice::read(const std::string& property) const {
  if (property == "vbus_voltage") return "23.950001";
  const std::size_t index = property.rfind("axis1", 0) == 0 ? 1 : 0;
  const std::string rest = property.size() > 6 ? property.substr(6) : "";
  if (rest == "error") return std::to_string(axes_[index].error);
  if (rest == "current_state") return std::to_string(axes_[index].state);
  return "invalid property";
}

std::string OdriveDevice::write(const std::string& property, double value) {
  Axis& axis = axes_[property.rfind("axis1", 0) == 0 ? 1 : 0];
  const std::string rest = property.size() > 6 ? property.substr(6) : "";
  if (rest == "requested_state") {
    const bool can_run = value != 8.0 || (axis.is_calibrated && axis.error == 0);
    axis.state = can_run ? static_cast<int>(value) : 1;
  } else if (rest == "config.watchdog_timeout") {
    axis.watchdog_s = value;
  } else if (rest == "config.enable_watchdog") {
    axis.has_watchdog = value != 0.0;
  } else if (rest == "controller.config.control_mode") {
    axis.control_mode = static_cast<int>(value);
  } else if (rest == "controller.config.input_mode") {
    axis.input_mode = static_cast<int>(value);
  } else {
    return "invalid property";
  }
  return {};
}

double OdriveDevice::target_rps(std::size_t index) const {
  const Axis& axis = axes_[index];
  return axis.state == 8 && axis.control_mode == 2 && axis.input_mode == 1 ? axis.target_tps * kRadPerTurn : 0.0;
}

Bytes OdriveDevice::step(Duration now, double left_angle_rad, double right_angle_rad) {
  const std::array<double, 2> turns{left_angle_rad / kRadPerTurn, right_angle_rad / kRadPerTurn};
  const double elapsed_s = to_seconds(now - stepped_);
  for (std::size_t i = 0; i < 2; ++i) {
    Axis& axis = axes_[i];
    if (elapsed_s > 0.0) axis.velocity_tps = (turns[i] - axis.position_t) / elapsed_s;
    axis.position_t = turns[i];
    if (axis.has_watchdog && axis.state == 8 && to_seconds(now - axis.fed) > axis.watchdog_s)
      axis.error |= kWatchdogExpired;
    if (axis.error != 0) axis.state = 1;
  }
  stepped_ = now;
  return {};
}

}  // namespace nacelle::simulation
