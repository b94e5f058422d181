// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// One command line of the host to a Waveshare UGV board, as the board reads it.
///
/// Written from the device's side on purpose: the driver's encoder is another reading of the same description.
/// Source: waveshareteam/ugv_base_ros, ROS_Driver/json_cmd.h and uart_ctrl.h.
struct UgvCommand {
  int type{};                         ///< The "T" field.
  std::optional<double> left, right;  ///< "L", "R"
  std::optional<double> x, z;         ///< "X", "Z"
  std::optional<double> cmd;          ///< "cmd"
};

/// Splits the host's bytes into lines and reads them; a line that is not a JSON object with a number "T" is counted.
///
/// Allocates: yes; the simulated world is a process of its own.
class UgvLineReader {
 public:
  struct Stats {
    std::uint64_t lines{};  ///< lines == commands + bad_lines
    std::uint64_t commands{};
    std::uint64_t bad_lines{};  ///< No JSON object, no "T", or longer than the board's buffer.
  };

  /// Calls `on_command(const UgvCommand&, std::string_view line)` for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_command) {
    for (const std::uint8_t byte : bytes) {
      if (byte != '\n') {
        // The board's receive document holds about 256 bytes; a longer line is lost there as well.
        if (line_.size() <= kLongestLine) line_.push_back(static_cast<char>(byte));
        continue;
      }
      ++stats_.lines;
      const auto command = line_.size() > kLongestLine ? std::nullopt : parse(line_);
      if (command) {
        ++stats_.commands;
        on_command(*command, std::string_view{line_});
      } else {
        ++stats_.bad_lines;
      }
      line_.clear();
    }
  }
  [[nodiscard]] const Stats& stats() const { return stats_; }

  /// Reads one line without its line feed.
  [[nodiscard]] static std::optional<UgvCommand> parse(std::string_view line);

 private:
  static constexpr std::size_t kLongestLine = 256;
  std::string line_;
  Stats stats_;
};

/// The board's answer T 1001, with the fields of firmware 9434682.
struct UgvFeedback {
  double left_mps{}, right_mps{};             ///< "L", "R"
  double roll_deg{}, pitch_deg{}, yaw_deg{};  ///< "r", "p", "y"
  double q0 = 1.0, q1{}, q2{}, q3{};
  double ax{}, ay{}, az = 1000.0;                ///< mg
  double gx{}, gy{}, gz{};                       ///< deg/s
  double odometry_left_m{}, odometry_right_m{};  ///< "odl", "odr"
  double volts = 12.0;                           ///< "v"
};

/// The line with its CR LF, as Serial.println() ends it. Numbers lose trailing zeros, as ArduinoJson prints them.
[[nodiscard]] std::string print_feedback(const UgvFeedback& feedback);

}  // namespace nacelle::simulation
