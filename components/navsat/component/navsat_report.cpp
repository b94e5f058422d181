// SPDX-License-Identifier: Apache-2.0
#include "navsat/component/navsat_report.hpp"

#include <utility>

namespace nacelle::navsat {
namespace {

constexpr int kPatience = 5;  // checks before a wait is reported
constexpr int kLooksBetweenWaits = 30;

Refusal main_cause(const InputCounters& now, const InputCounters& before) {
  std::size_t most = 0;
  for (std::size_t i = 1; i < kRefusals; ++i) {
    if (now.refused[i] - before.refused[i] > now.refused[most] - before.refused[most]) most = i;
  }
  return static_cast<Refusal>(most);
}

void add(const char* input, const InputCounters& counters, diagnostic_msgs::msg::DiagnosticStatus& status) {
  const auto put = [&](const std::string& key, std::uint64_t value) {
    auto& pair = status.values.emplace_back();
    pair.key = key;
    pair.value = std::to_string(value);
  };
  put(std::string(input) + "_used", counters.used);
  for (std::size_t i = 0; i < kRefusals; ++i) {
    if (counters.refused[i] != 0) put(std::string(input) + "_refused_" + kRefusalNames[i], counters.refused[i]);
  }
}

}  // namespace

bool NavsatReport::look_at(const char* name, const InputCounters& now, Seen& seen, const Logger& logger) {
  const bool used = now.used > seen.counters.used;
  const Refusal cause = main_cause(now, seen.counters);
  const bool refused = now.of(cause) > seen.counters.of(cause);
  if (refused && (!seen.told || seen.cause != cause)) {
    logger.warn("{} is not used: {} ({} so far)", name, explain(cause), now.of(cause));
    seen.told = true;
    seen.cause = cause;
  } else if (used && !refused && seen.told) {
    logger.info("{} is used again", name);
    seen.told = false;
  }
  seen.counters = now;
  return refused;
}

void NavsatReport::look(const NavsatStats& now, const std::string& waits_for, const Logger& logger) {
  is_troubled_ = look_at("gps/fix", now.fixes, fixes_, logger);
  is_troubled_ |= look_at("odometry/filtered", now.odometry, odometry_, logger);
  is_troubled_ |= look_at("imu", now.imu, imu_, logger);
  if (now.unknown_covariance > std::exchange(unknown_covariance_, now.unknown_covariance) &&
      now.unknown_covariance == now.fixes.used)
    logger.warn_throttle(60s, "gps/fix has no covariance: it gets that of the parameter stddev_if_unknown");
  if (now.other_zone > 0 && std::exchange(other_zone_, now.other_zone) == 0)
    logger.info("the robot left the UTM zone of its datum; its positions stay in that zone");
  if (now.without_antenna > std::exchange(without_antenna_, now.without_antenna)) {
    is_troubled_ = true;
    logger.warn_throttle(60s, "no transform says where the antenna is on the base: it counts as the base's origin");
  }
  waiting_looks_ = waits_for.empty() ? 0 : waiting_looks_ + 1;
  if (waiting_looks_ >= kPatience && (waiting_looks_ - kPatience) % kLooksBetweenWaits == 0)
    logger.warn("no output yet: waiting for {}", waits_for);
}

void NavsatReport::write(const NavsatStats& now, const std::string& waits_for, const std::string& node,
                         diagnostic_msgs::msg::DiagnosticArray& out) const {
  using diagnostic_msgs::msg::DiagnosticStatus;
  out.status.resize(1);
  DiagnosticStatus& status = out.status[0];
  status.name = node + ": gps";
  status.hardware_id = node;
  status.values.clear();
  const bool waits = !waits_for.empty();
  status.level = waits || is_troubled_ ? DiagnosticStatus::WARN : DiagnosticStatus::OK;
  status.message = waits ? "waiting for " + waits_for : is_troubled_ ? "some messages are not used" : "aligned";
  add("fix", now.fixes, status);
  add("odometry", now.odometry, status);
  add("imu", now.imu, status);
  for (const auto& [key, value] : {std::pair{"published", now.published},
                                   {"overtaken", now.overtaken},
                                   {"unknown_covariance", now.unknown_covariance},
                                   {"other_zone", now.other_zone},
                                   {"without_antenna", now.without_antenna}}) {
    auto& pair = status.values.emplace_back();
    pair.key = key;
    pair.value = std::to_string(value);
  }
}

}  // namespace nacelle::navsat
