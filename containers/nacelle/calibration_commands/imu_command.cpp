// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "calibration_commands/commands.hpp"
#include "calibration_commands/imu_calibration.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {

void add_imu_commands(Command& root) {
  auto wish = std::make_shared<ImuWish>();
  Command& group = root.add("imu", "inertial sensors");
  Command& command = group.add("calibrate", "measure the errors of an IMU, and write its corrections as parameters");
  command.option("--node", wish->node, "the IMU's node").with_default().names_a(Names::Node);
  command.option("-o,--output", wish->output, "the parameter file").with_default().names_a(Names::File);
  command.flag("--gyro", wish->gyro, "the gyro's bias, at rest");
  command.flag("--accel", wish->accel, "the accelerometer's bias and scale, from six sides");
  command.flag("--mag", wish->mag, "the magnetometer's hard and soft iron, from turns");
  command.flag("--drive", wish->drive, "mounting yaw and lever arm, from figures of eight that the robot drives");
  command.option("--data", wish->data, "the topic of the readings; a relative name is beside the node")
      .with_default()
      .names_a(Names::Topic);
  command.option("--field", wish->field, "the topic of the magnetic field").with_default().names_a(Names::Topic);
  command.option("--rest", wish->rest_s, "s of readings at rest").value("SECONDS").with_default().within(0.5, 600.0);
  command.option("--turn", wish->turn_s, "s of readings while it is turned")
      .value("SECONDS")
      .with_default()
      .within(1.0, 600.0);
  command.option("--wait", wish->wait_s, "longest time without a message, in s")
      .value("SECONDS")
      .with_default()
      .within(0.5, 600.0);
  auto& course = wish->course;
  command.option("--base", course.base, "the base's node, for --drive").with_default().names_a(Names::Node);
  command.option("--radius", course.radius_m, "m, of the circles").value("METRES").with_default().within(0.1, 10.0);
  command.option("--yaw-rate", course.yaw_rate_rps, "rad/s on the circles")
      .value("RATE")
      .with_default()
      .within(0.2, 4.0);
  command.option("--eights", course.eights, "figures of eight to drive").with_default().within(1, 50);
  command.option("--topic", course.command, "topic for the commands; a relative name is beside the base")
      .with_default()
      .names_a(Names::Topic);
  command.flag("--twist", course.twist, "send Twist instead of TwistStamped");
  command.option("--joint-states", course.joints, "topic of the wheels' positions")
      .with_default()
      .names_a(Names::Topic);
  command.flag("-y,--yes", course.yes, "drive without asking first");
  add_container_option(command, wish->container);
  command.note(
      "Without --gyro, --accel, --mag and --drive: all that the IMU has, without a drive. The IMU must be active.\n"
      "Instructions go to stderr, answers are read from stdin. Ctrl-C stops the wheels, ends it with exit code 130 "
      "and\n"
      "writes nothing.");
  command.runs([wish] { return calibrate_imu(*wish); });
}

}  // namespace nacelle::cli
