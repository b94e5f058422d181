// SPDX-License-Identifier: Apache-2.0
#include "drives.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "simulation/model/drive_model.hpp"
#include "simulation/model/sensor_models.hpp"

namespace nacelle::ekf::honesty {
namespace {

constexpr double kStep_s = 0.001;
constexpr int kWheelEvery = 20, kGyroEvery = 10, kTruthEvery = 5, kRestSteps = 1500;

// Speeds and turns as a person drives: straight, in arcs, on the spot, and standing.
class Commands {
 public:
  explicit Commands(std::uint64_t seed) : random_(seed) {}

  void step(double t_s) {
    if (t_s >= until_s_) draw(t_s);
    speed_mps_ += std::clamp(wanted_speed_ - speed_mps_, -1.0 * kStep_s, 1.0 * kStep_s);
    yaw_rate_rps_ += std::clamp(wanted_rate_ - yaw_rate_rps_, -4.0 * kStep_s, 4.0 * kStep_s);
  }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }
  [[nodiscard]] double yaw_rate_rps() const { return yaw_rate_rps_; }

 private:
  void draw(double t_s) {
    std::uniform_real_distribution<double> any{0.0, 1.0};
    until_s_ = t_s + 1.0 + 3.0 * any(random_);
    const double kind = any(random_);
    wanted_speed_ = kind < 0.85 ? 0.1 + 0.4 * any(random_) : 0.0;
    if (kind < 0.15) wanted_speed_ = -0.5 * wanted_speed_;
    wanted_rate_ = kind < 0.4 ? 0.0 : 1.2 * (2.0 * any(random_) - 1.0);
    if (kind > 0.93) wanted_rate_ = 0.0;
  }
  std::mt19937_64 random_;
  double until_s_ = 0.0, wanted_speed_ = 0.0, wanted_rate_ = 0.0, speed_mps_ = 0.0, yaw_rate_rps_ = 0.0;
};

std::vector<std::vector<std::string>> rows_of(const std::string& path) {
  std::ifstream in{path};
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    std::stringstream cells{line};
    auto& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
  }
  return rows;
}

}  // namespace

std::optional<TruePose> Drive::true_pose(double t_s) const {
  const auto after = std::ranges::lower_bound(truth, t_s, {}, &TruePose::t_s);
  if (after == truth.end() || (after == truth.begin() && after->t_s > t_s)) return std::nullopt;
  if (after->t_s == t_s) return *after;
  const TruePose& a = *(after - 1);
  const TruePose& b = *after;
  const double share = (t_s - a.t_s) / (b.t_s - a.t_s);
  return TruePose{t_s, a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m),
                  a.yaw_rad + share * (b.yaw_rad - a.yaw_rad)};
}

Drive simulated(const SimulatedDrive& how) {
  simulation::WorldSettings settings;
  settings.seed = how.seed;
  const simulation::Room room{{{-500, -500, -500, 500}}};
  simulation::DriveModel world{settings, room};
  simulation::ImuModel imu{settings};
  Commands commands{how.seed};
  const auto& robot = settings.robot;
  const double per_count = 2.0 * std::numbers::pi / robot.counts_per_turn * robot.wheel_radius_m;
  constexpr double kRadians = std::numbers::pi / 180.0;

  Drive drive{"seed " + std::to_string(how.seed), robot.track_m, {}, {}, {}};
  double left = 0.0, right = 0.0, bias_rps = 0.0;
  int rest_samples = 0;
  const int steps = static_cast<int>(how.seconds / kStep_s);
  for (int i = 1; i <= steps; ++i) {
    const double t_s = i * kStep_s;
    if (i > kRestSteps) commands.step(t_s);
    const double half = 0.5 * robot.track_m * commands.yaw_rate_rps();
    world.step(kStep_s, (commands.speed_mps() - half) / robot.wheel_radius_m,
               (commands.speed_mps() + half) / robot.wheel_radius_m);
    if (i % kTruthEvery == 0) drive.truth.push_back({t_s, world.pose().x_m, world.pose().y_m, world.pose().yaw_rad});
    if (i % kGyroEvery == 0) {
      const double rate = imu.measure(world).angular_velocity_dps[2] * kRadians;
      if (how.calibrates_gyro && rest_samples < 100) bias_rps += (rate - bias_rps) / ++rest_samples;
      drive.gyro.push_back({t_s, rate});
    }
    if (i % kWheelEvery != 0) continue;
    const double turns = robot.counts_per_turn / (2.0 * std::numbers::pi);
    const double left_now = std::floor(world.left_angle_rad() * turns) * per_count;
    const double right_now = std::floor(world.right_angle_rad() * turns) * per_count;
    drive.wheels.push_back({t_s, kWheelEvery * kStep_s, {left_now - left, right_now - right}});
    left = left_now;
    right = right_now;
  }
  for (GyroReading& reading : drive.gyro) reading.yaw_rate_rps -= bias_rps;
  return drive;
}

Drive recorded(const std::string& folder, const std::string& turn) {
  Drive drive{folder, 1.0, {}, {}, {}};
  double before_s = 0.0;
  const auto truth = rows_of(folder + "/truth.csv");
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const double yaw = std::stod(truth[i][3]);
    const double last = drive.truth.empty() ? yaw : drive.truth.back().yaw_rad;
    drive.truth.push_back({std::stod(truth[i][0]), std::stod(truth[i][1]), std::stod(truth[i][2]),
                           last + std::remainder(yaw - last, 2.0 * std::numbers::pi)});
  }
  const auto odometry = rows_of(folder + "/odometry.csv");
  if (odometry.empty() || drive.truth.empty()) return drive;
  const auto column = std::ranges::find(odometry[0], turn) - odometry[0].begin();
  before_s = drive.truth.front().t_s;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    const double t_s = std::stod(odometry[i][0]), distance_m = std::stod(odometry[i][1]);
    const double half_m = 0.5 * drive.separation_m * std::stod(odometry[i].at(static_cast<std::size_t>(column)));
    if (t_s > before_s) drive.wheels.push_back({t_s, t_s - before_s, {distance_m - half_m, distance_m + half_m}});
    before_s = t_s;
  }
  return drive;
}

}  // namespace nacelle::ekf::honesty
