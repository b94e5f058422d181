// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "odometry/model/wheel_odometry.hpp"

namespace nacelle::odometry {

struct JointReaderOptions {
  std::vector<std::string> left_names, right_names;
  double left_radius_m{}, right_radius_m{};
  double max_wheel_speed_rps =
      40.0;  ///< Faster than any wheel of the robot turns; a larger step is a jump, not a motion.
};

/// samples == steps + first + jumps + incomplete + not_finite + repeated + time_jumps.
struct JointReaderStats {
  std::uint64_t samples{}, steps{};
  std::uint64_t first{};  ///< Started the differences.
  std::uint64_t jumps{};  ///< A wheel position that no wheel can have reached: the board was restarted. Not integrated.
  std::uint64_t incomplete{};  ///< A wheel is missing, or names and positions differ in number.
  std::uint64_t not_finite{};
  std::uint64_t repeated{};    ///< Less than 0.1 ms after the last one.
  std::uint64_t time_jumps{};  ///< Older than the last one: the clock was set. The differences start again.
};

/// Turns wheel positions into steps of the two sides.
///
/// Threads:   one. Allocates: in the constructor only.
/// Source:    diff_drive_controller, src/odometry.cpp, for the mean over a side's wheels and the 0.1 ms.
class JointReader {
 public:
  struct Step {
    WheelStep wheels;
    double dt_s{};
  };
  explicit JointReader(const JointReaderOptions& options);

  /// The step since the last sample, or nothing if this one only starts the differences or is not usable.
  [[nodiscard]] std::optional<Step> read(WallTime stamp, std::span<const std::string> names,
                                         std::span<const double> positions_rad);
  /// Forgets the last sample; the next one only starts the differences.
  void restart() { last_.reset(); }
  [[nodiscard]] const JointReaderStats& stats() const { return stats_; }

 private:
  struct Side {
    std::vector<std::string> names;
    std::vector<std::size_t> places;  // where each name stood in the last message: it will stand there again
    double radius_m{};
  };
  struct Sample {
    WallTime stamp;
    double left_rad{}, right_rad{};
  };
  [[nodiscard]] static bool mean_of(Side& side, std::span<const std::string> names,
                                    std::span<const double> positions_rad, double& mean_rad);
  Side left_, right_;
  double max_wheel_speed_rps_;
  std::optional<Sample> last_;
  JointReaderStats stats_;
};

}  // namespace nacelle::odometry
