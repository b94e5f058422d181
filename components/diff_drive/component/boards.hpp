// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "diff_drive/component/diff_drive_options.hpp"
#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "nacelle/io/can_port.hpp"

namespace nacelle::diff_drive {

/// A kind of motor board: a value of the parameter `hardware` other than loopback.
struct BoardKind {
  std::string_view name;
  bool is_pwm = false;           ///< No board: this computer's own pins (open_pwm_base()).
  bool is_on_can = false;        ///< On the interface can_interface, not on serial_port.
  unsigned usual_baud = 115200;  ///< Where baud_rate is 0.
  int lowest_channel = 0;        ///< Channels that left_channel and right_channel may name; equal to the highest: none.
  int highest_channel = 0;
  int usual_left = 0, usual_right = 0;  ///< Where the parameters are -1.
  double usual_counts_per_turn =
      0.0;                     ///< Where counts_per_turn is 0; 0 here: it must be given. Without channels: unused.
  bool reports_wheels = true;  ///< False: joint states are what was commanded.
  bool has_watchdog = true;    ///< False: the wheels keep their speed when the line falls silent.
};
/// Returns null if there is none of this name.
[[nodiscard]] const BoardKind* board_kind(std::string_view hardware);
/// Returns every value of `hardware`, loopback last.
[[nodiscard]] const std::vector<std::string>& hardware_names();

/// Checks the parameters of the board; `node` is the node that has them. Precondition: board_kind(options.hardware).
[[nodiscard]] std::optional<Problem> problem_of_board(const DiffDriveOptions& options, const std::string& node);
/// Returns the wheels' channels, directions and counts. Precondition: as of problem_of_board().
[[nodiscard]] BaseWiring wiring_of_board(const DiffDriveOptions& options);
/// Precondition: problem_of_board() finds none, and the kind is a board.
[[nodiscard]] std::unique_ptr<MotorBoard> make_board(const DiffDriveOptions& options);
/// Returns what the kernel shall let through to boards on CAN. Precondition: as of make_board(), and the kind is_on_can.
[[nodiscard]] std::vector<io::CanFilter> filters_of_board(const DiffDriveOptions& options);
/// Adds what a user of this board must know of its limits. Precondition: the kind is known, or loopback.
void warn_of_board(const DiffDriveOptions& options, std::vector<std::string>& warnings);
/// Returns the line of the board as the parameters name it: a path, or a CAN interface; "loopback" without a board.
[[nodiscard]] const std::string& line_of_board(const DiffDriveOptions& options);

}  // namespace nacelle::diff_drive
