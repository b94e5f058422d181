// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "ekf/model/covariance_parameter.hpp"
#include "ekf/model/filter.hpp"

namespace nacelle::ekf {

/// Something that is measured, and when the filter hears of it; both since the start.
struct Told {
  Duration stamp{};
  Duration arrives{};
  std::uint16_t part{};
  Reading reading;
};

inline constexpr WallTime kLateStart{1000s};

inline FilterOptions late_options(std::size_t parts, std::optional<Duration> history) {
  FilterOptions o;
  o.process_noise = ProcessNoise{default_process_noise()};
  o.initial.covariance = default_initial_covariance();
  o.period = o.sensor_timeout = 20ms;
  o.parts = parts;
  o.history = history;
  return o;
}

/// A drive in bends: wheels (part 0, 50 Hz), a gyro (part 1, 100 Hz) and poses (part 2, 10 Hz) that come late. The wheels slip, so that
/// the poses matter.
class LateDrive {
 public:
  static constexpr std::uint16_t kWheels = 0, kGyro = 1, kPoses = 2;

  explicit LateDrive(unsigned seed = 1) : random_(seed) {}

  struct Truth {
    double x{}, y{}, yaw{}, v{}, w{};
  };
  /// The last pose is measured so long before the end that it has come by then.
  std::vector<Told> measure(Duration length, Duration late) {
    std::vector<Told> all;
    Truth truth;
    for (Duration t{}; t <= length; t += 10ms) {
      const double s = to_seconds(t);
      truth.v = 0.4 + 0.2 * std::sin(0.7 * s);
      truth.w = 0.5 * std::sin(0.9 * s);
      tracks_.push_back(truth);
      if (t % 20ms == 0ns) {
        Told& wheels = all.emplace_back(Told{t, t, kWheels, {}});
        wheels.reading.add(kVx, truth.v * 1.03 + 0.01 * normal_(random_), 1e-3);
        wheels.reading.add(kVy, 0.0, 1e-3);
      }
      all.emplace_back(Told{t, t, kGyro, {}}).reading.add(kVyaw, truth.w + 0.01 + 0.005 * normal_(random_), 1e-4);
      if (t % 100ms == 0ns && t + 400ms <= length) {
        Told& pose = all.emplace_back(Told{t, t + late, kPoses, {}});
        pose.reading.add(kX, truth.x + 0.01 * normal_(random_), 1e-4);
        pose.reading.add(kY, truth.y + 0.01 * normal_(random_), 1e-4);
        pose.reading.add(kYaw, truth.yaw + 0.005 * normal_(random_), 2.5e-5);
      }
      // In pieces, so that the truth is no Euler step.
      for (int i = 0; i < 10; ++i) {
        truth.yaw += 0.0005 * truth.w;
        truth.x += 0.001 * truth.v * std::cos(truth.yaw);
        truth.y += 0.001 * truth.v * std::sin(truth.yaw);
        truth.yaw += 0.0005 * truth.w;
      }
    }
    return all;
  }
  [[nodiscard]] const Truth& truth(Duration t) const { return tracks_[static_cast<std::size_t>(t / 10ms)]; }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<Truth> tracks_;
};

/// Gives a filter what it is told, in the order of arrival, with a step every 20 ms; calls `after(time)` after each.
template <typename F>
void run_filter(Filter& filter, std::vector<Told> told, Duration length, F&& after) {
  std::stable_sort(told.begin(), told.end(), [](const Told& a, const Told& b) { return a.arrives < b.arrives; });
  auto next = told.begin();
  for (Duration t{}; t <= length; t += 20ms) {
    for (; next != told.end() && next->arrives <= t; ++next) {
      filter.offer(next->part, kLateStart + next->stamp, kLateStart + next->arrives, [&](Reading& r) -> Prepared {
        r = next->reading;
        return {};
      });
    }
    filter.step(kLateStart + t, MonotonicTime{1s + t});
    after(t);
  }
}
inline void run_filter(Filter& filter, std::vector<Told> told, Duration length) {
  run_filter(filter, std::move(told), length, [](Duration) {});
}

/// The largest difference of two beliefs, in the mean or in the covariance.
inline double difference(const Belief& a, const Belief& b) {
  StateVector mean = a.mean - b.mean;
  for (int i = kRoll; i <= kYaw; ++i) mean[i] = spatial::wrap_to_pi(mean[i]);
  const double covariance = (a.covariance.matrix() - b.covariance.matrix()).cwiseAbs().maxCoeff();
  return std::max(mean.cwiseAbs().maxCoeff(), covariance);
}

/// Whether received == fused + rejected + waiting holds for every part.
inline bool adds_up(const Filter& filter, std::size_t parts) {
  for (std::size_t part = 0; part < parts; ++part) {
    const PartStats& s = filter.stats(part);
    std::uint64_t sum = s.fused + s.waiting;
    for (const std::uint64_t n : s.rejected) sum += n;
    if (s.received != sum) return false;
  }
  return true;
}

}  // namespace nacelle::ekf
