// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::diff_drive {

// What a Waveshare UGV board sends: one flat JSON object per line, T 1001 for the base. Fields by age of the firmware:
// Source: waveshareteam/ugv_base_ros, ROS_Driver/ugv_advance.h at 53c25eb, at 9434682, and the newest one read.
//
//   field         53c25eb   9434682   newest              becomes
//   L, R          m/s       m/s       m/s                 left_mps, right_mps
//   odl, odr      -         m         integer cm          left_travel_m, right_travel_m
//   v             V         V         integer 0.01 V      voltage_v
//   r, p          deg       deg       -                   roll_rad, pitch_rad
//   y             -         deg       -                   yaw_rad (53c25eb uses the name for the arm: not taken)
//   q0..q3, ax..az, gx..gz, mx..mz, arm and gimbal        skipped; the IMU is a component of its own
//
// The newest firmware is recognised by its mx: no older one sends the magnetometer, and only it sends raw integers.

/// One T 1001 line in SI units. Empty fields were not in the line.
struct BaseFeedback {
  double left_mps = 0.0;  ///< Speed of the left wheel's rim; positive drives forward.
  double right_mps = 0.0;
  std::optional<double> left_travel_m;  ///< Since the board started.
  std::optional<double> right_travel_m;
  std::optional<double> voltage_v;
  std::optional<double> roll_rad;
  std::optional<double> pitch_rad;
  std::optional<double> yaw_rad;
  friend bool operator==(const BaseFeedback&, const BaseFeedback&) = default;
};

/// Why a line gave no base feedback.
enum class LineFault : std::uint8_t {
  Malformed,  ///< Not one flat JSON object with a numeric T, or a T 1001 without L and R or with values no base has.
  OtherType,  ///< A well-formed line of another T (IMU, echo, servo error).
};

/// Reads one line (without its end). Allocates: nothing.
[[nodiscard]] Result<BaseFeedback, LineFault> decode_base_feedback(std::string_view line);

/// Cuts bytes into lines and decodes them; takes any chopping.
///
/// Lines longer than kMaxLineBytes are skipped to their end. Every byte is accounted for:
/// bytes == feedback_bytes + other_bytes + malformed_bytes + overlong_bytes + blank_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
class WaveshareLineDecoder {
 public:
  /// The board's own document holds about 256 bytes, its longest feedback line stays below 400.
  static constexpr std::size_t kMaxLineBytes = 512;

  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t feedback_lines = 0, feedback_bytes = 0;  ///< Bytes include the line feed.
    std::uint64_t other_lines = 0, other_bytes = 0;        ///< LineFault::OtherType.
    std::uint64_t malformed_lines = 0,
                  malformed_bytes = 0;  ///< LineFault::Malformed; the first line after opening often is.
    std::uint64_t overlong_lines = 0, overlong_bytes = 0;
    std::uint64_t blank_bytes = 0;  ///< Of empty lines.
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_feedback(const BaseFeedback&) for each T 1001 line that ends in these bytes.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_feedback) {
    while (!bytes.empty()) {
      if (const auto feedback = take_line(bytes)) on_feedback(*feedback);
    }
  }
  /// Forgets the line that has begun (its bytes count as malformed): after a line was reopened.
  void restart();

  [[nodiscard]] const Stats& stats() const { return stats_; }
  /// Bytes of a line whose end has not come yet.
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  [[nodiscard]] std::optional<BaseFeedback> take_line(ByteView& bytes);
  [[nodiscard]] std::optional<BaseFeedback> finish_line(std::string_view line, std::size_t line_bytes);

  std::array<char, kMaxLineBytes> line_{};
  std::size_t pending_ = 0;  // may exceed kMaxLineBytes: then the line is overlong and line_ is void
  Stats stats_;
};

}  // namespace nacelle::diff_drive
