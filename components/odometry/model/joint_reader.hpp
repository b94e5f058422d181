// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "odometry/model/position_unwrap.hpp"
#include "odometry/model/wheel_odometry.hpp"

namespace nacelle::odometry {

struct JointReaderOptions {
  std::vector<std::string> left_names, right_names;
  double left_radius_m{}, right_radius_m{};
  double max_wheel_speed_rps =
      40.0;  ///< Faster than any wheel of the robot turns; a larger step is a jump, not a motion.
  double position_range_rad = 0.0;  ///< Positions count in a circle of so much; 0: found out (PositionUnwrap).
};

/// samples == steps + first + jumps + incomplete + not_finite + repeated + time_jumps + gaps.
struct JointReaderStats {
  std::uint64_t samples{}, steps{};
  std::uint64_t first{};  ///< Started the differences.
  std::uint64_t jumps{};  ///< A wheel position that no wheel can have reached: the board was restarted. Not integrated.
  std::uint64_t incomplete{};  ///< A wheel is missing, or names and positions differ in number.
  std::uint64_t not_finite{};
  std::uint64_t repeated{};    ///< Less than 0.1 ms after the last one.
  std::uint64_t time_jumps{};  ///< Older than the last one: the clock was set. The differences start again.
  std::uint64_t gaps{};        ///< Speeds alone, and too long after the last one to say how far the wheels turned.
};

/// Turns wheel positions into steps of the two sides, or wheel speeds where there are no positions.
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
  /// Empty positions: the speeds count. Speeds beside positions help to find the end of a circle; they may be empty.
  [[nodiscard]] std::optional<Step> read(WallTime stamp, std::span<const std::string> names,
                                         std::span<const double> positions_rad,
                                         std::span<const double> speeds_rps = {});
  /// Forgets the last sample; the next one only starts the differences.
  void restart();
  /// A wheel of the side counts in a circle of so much; 0: in none that is known.
  [[nodiscard]] double range_rad(bool left) const { return (left ? left_ : right_).wheels.front().unwrap.range_rad(); }
  [[nodiscard]] const JointReaderStats& stats() const { return stats_; }

 private:
  struct Wheel {
    std::string name;
    std::size_t place{};  // where it stood in the last message: it will stand there again
    PositionUnwrap unwrap;
    double speed_rps{};  // at the last sample: as it was measured, else as it was turned
  };
  struct Side {
    std::vector<Wheel> wheels;
    double radius_m{};
  };
  struct Values {
    std::span<const double> positions_rad, speeds_rps;
    [[nodiscard]] std::span<const double> counting() const {
      return positions_rad.empty() ? speeds_rps : positions_rad;
    }
  };
  [[nodiscard]] static Side side_of(const std::vector<std::string>& names, double radius_m, double range_rad);
  /// Finds the wheels' places; false if one is missing.
  [[nodiscard]] static bool find(Side& side, std::span<const std::string> names);
  [[nodiscard]] static bool is_finite(const Side& side, std::span<const double> values);
  /// The mean step of a side's wheels; nothing if one has jumped. A step of zero time starts the differences.
  [[nodiscard]] std::optional<double> step_of(Side& side, const Values& values, double dt_s) const;
  std::optional<Step> start(WallTime stamp, const Values& values);

  Side left_, right_;
  double max_wheel_speed_rps_;
  std::optional<WallTime> last_;
  double oldest_s_{};  // a position may have been measured so long before its stamp
  JointReaderStats stats_;
};

}  // namespace nacelle::odometry
