// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "calibration_commands/base_calibration.hpp"
#include "calibration_commands/commands.hpp"
#include "calibration_commands/umbmark_calibration.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {

void add_base_commands(Command& root) {
  auto wish = std::make_shared<BaseWish>();
  Command& group = root.add("base", "the wheels of a robot");
  Command& command = group.add(
      "calibrate",
      "drive a straight line and turns on the spot, or squares, and write the multipliers of the wheels as parameters");
  command.option("--node", wish->node, "the base's node").with_default().names_a(Names::Node);
  command.option("-o,--output", wish->output, "the parameter file").with_default().names_a(Names::File);
  command.option("--distance", wish->distance_m, "m to drive straight ahead; 0: leave it out")
      .value("METRES")
      .with_default()
      .within(0.0, 50.0);
  command.option("--turns", wish->turns, "turns on the spot, counter-clockwise; 0: leave them out")
      .with_default()
      .within(0.0, 50.0);
  command.option("--measured-distance", wish->measured_distance_m, "m that it really drives, instead of the question")
      .value("METRES")
      .within(0.01, 100.0);
  command.option("--measured-turns", wish->measured_turns, "turns that it really makes, instead of the question")
      .within(0.01, 100.0);
  command
      .option("--turns-by", wish->gyro,
              "a level gyro's topic (sensor_msgs/Imu) that measures the turns, instead of the question")
      .not_with("--measured-turns")
      .names_a(Names::Topic);
  command.flag("--umbmark", wish->umbmark,
               "drive squares both ways (UMBmark) instead of the turns: they show which wheel is larger, and the slip");
  command.option("--side", wish->side_m, "m of a square's side").value("METRES").with_default().within(0.2, 20.0);
  command.option("--squares", wish->squares, "squares each way").with_default().within(1, 50);
  command
      .option("--measured-end", wish->measured_ends,
              "where a square really ends: m ahead and left of its mark; one for each square, clockwise ones first")
      .value("X,Y")
      .checked(wrong_end);
  command
      .option("--truth", wish->truth,
              "a topic that measures where the robot is (Odometry, PoseStamped, PoseWithCovarianceStamped), instead of "
              "the questions")
      .not_with("--measured-end")
      .names_a(Names::Topic);
  command.option("--odometry", wish->odometry, "the odometry's node, for the slip").with_default().names_a(Names::Node);
  command.option("--speed", wish->speed_mps, "forward speed in m/s").with_default().within(0.02, 1.0);
  command.option("--turn", wish->yaw_rate_rps, "turning speed in rad/s").with_default().within(0.05, 3.0);
  command.option("--topic", wish->command, "topic for the commands; a relative name is beside the node")
      .with_default()
      .names_a(Names::Topic);
  command.flag("--twist", wish->twist, "send Twist instead of TwistStamped");
  command.option("--joint-states", wish->joints, "topic of the wheels' positions").with_default().names_a(Names::Topic);
  command.option("--wait", wish->wait_s, "longest time without a position of the wheels, in s; they stop after 0.5 s")
      .value("SECONDS")
      .with_default()
      .within(0.5, 600.0);
  command.flag("-y,--yes", wish->yes, "drive without asking first");
  add_container_option(command, wish->container);
  command.note(
      "It changes left_wheel_radius_multiplier, right_wheel_radius_multiplier and wheel_separation_multiplier; "
      "--umbmark\n"
      "also slip.distance_stddev_per_sqrt_m, slip.heading_stddev_per_sqrt_m and slip.heading_stddev_per_sqrt_rad of "
      "the odometry.\n"
      "Instructions go to stderr, answers are read from stdin. Ctrl-C stops the wheels, ends it with exit code 130 "
      "and\n"
      "writes nothing.");
  command.runs([wish] { return calibrate_base(*wish); });
}

}  // namespace nacelle::cli
