// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/assist_report.hpp"

#include <fmt/format.h>

#include <cmath>

namespace nacelle::ekf {
namespace {

constexpr int kLooksBetweenTellings = 10;
constexpr double kKnown = 0.1;  // of the standard deviation at the start

double yaw_bias_stddev(const Filter& filter) { return std::sqrt(filter.assists().gyro_bias.covariance(2, 2)); }

}  // namespace

bool AssistWatch::is_due(Told& told, std::uint64_t count) {
  if (told.looks > 0) --told.looks;
  if (count < told.count) told.count = 0;  // the filter was reset
  if (count == told.count || told.looks > 0) return false;
  told = {count, kLooksBetweenTellings};
  return true;
}

void AssistWatch::look(const Filter& filter, const EkfOptions& options, const Logger& logger) {
  const AssistOptions& on = options.filter.assists;
  const AssistState& state = filter.assists();
  if (on.slip.on && is_due(slip_, state.slip.episodes))
    logger.warn("{}: the wheels slip or slipped ({} times so far); meanwhile their velocity counts less",
                options.assist_wheels, state.slip.episodes);
  if (on.slip.on && state.slip.distrusts_imu != distrusts_) {
    distrusts_ = state.slip.distrusts_imu;
    if (distrusts_) {
      logger.warn(
          "{} and {} disagree for longer than wheels slip: check axes, sign and scale of the IMU. No slip is seen "
          "until they agree",
          options.assist_imu, options.assist_wheels);
    } else {
      logger.info("{} and {} agree again: slip is seen", options.assist_imu, options.assist_wheels);
    }
  }
  if (on.standstill.on && is_due(contradiction_, state.standstill.contradictions))
    logger.warn("{} stands while {} moves ({} times so far): no zero velocity is fused meanwhile",
                options.assist_wheels, options.assist_imu, state.standstill.contradictions);
  if (!on.gyro_bias.on) return;
  const bool known = yaw_bias_stddev(filter) < kKnown * on.gyro_bias.stddev_rps;
  if (known && !bias_known_)
    logger.info("{}: the gyro's yaw bias is {:.5f} rad/s +- {:.5f}", options.assist_imu, state.gyro_bias.mean_rps.z(),
                yaw_bias_stddev(filter));
  bias_known_ = bias_known_ || known;
}

void write_assist_diagnostics(const Filter& filter, const EkfOptions& options, const std::string& node,
                              diagnostic_msgs::msg::DiagnosticArray& out) {
  using diagnostic_msgs::msg::DiagnosticStatus;
  const AssistOptions& on = options.filter.assists;
  const AssistState& state = filter.assists();
  const auto begin = [&](const char* what, bool doubtful, std::string message) -> DiagnosticStatus& {
    DiagnosticStatus& status = out.status.emplace_back();
    status.level = doubtful ? DiagnosticStatus::WARN : DiagnosticStatus::OK;
    status.name = fmt::format("{}: {}", node, what);
    status.message = std::move(message);
    status.hardware_id = "none";
    return status;
  };
  const auto add = [](DiagnosticStatus& status, const char* key, const auto& value) {
    auto& pair = status.values.emplace_back();
    pair.key = key;
    pair.value = fmt::format("{}", value);
  };
  if (on.gyro_bias.on) {
    DiagnosticStatus& status = begin("gyro bias", false, options.assist_imu);
    add(status, "x_rps", state.gyro_bias.mean_rps.x());
    add(status, "y_rps", state.gyro_bias.mean_rps.y());
    add(status, "z_rps", state.gyro_bias.mean_rps.z());
    add(status, "z_stddev_rps", yaw_bias_stddev(filter));
  }
  if (on.standstill.on) {
    const Standstill& s = state.standstill;
    DiagnosticStatus& status = begin("standstill", s.contradicted,
                                     s.contradicted ? "the wheels stand, the IMU moves"
                                     : s.standing   ? "stands"
                                                    : "moves");
    add(status, "zero_velocity_updates", s.updates);
    add(status, "contradictions", s.contradictions);
  }
  if (!on.slip.on) return;
  const Slip& s = state.slip;
  DiagnosticStatus& status = begin("slip", s.slipping || s.distrusts_imu,
                                   s.distrusts_imu ? "IMU and wheels disagree: no slip is seen"
                                   : s.slipping    ? "the wheels slip"
                                                   : "the wheels hold");
  add(status, "episodes", s.episodes);
  add(status, "inflated", s.inflated);
  add(status, "distrusted", s.distrusted);
  add(status, "speed_gap_mps", s.speed_gap_mps);
  add(status, "yaw_rate_gap_rps", s.yaw_gap_rps);
}

}  // namespace nacelle::ekf
