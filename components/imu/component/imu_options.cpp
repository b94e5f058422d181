// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_options.hpp"

#include <fmt/format.h>

#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::imu {
namespace {

// A standard deviation of zero would claim a perfect sensor, and an all-zero covariance means "unknown".
constexpr double kLeastStddev = 1e-12;

ParameterDescriptor text(std::string description) { return {.description = std::move(description)}; }
ParameterDescriptor within(std::string description, double from, double to) {
  return {.description = std::move(description), .floating_point_range = FloatingPointRange{from, to}};
}

Problem refusal(const Node& node, const char* parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter, node.get_fully_qualified_name()), std::move(what), std::move(way_out)};
}

}  // namespace

void declare_imu_parameters(Node& node) {
  const ImuOptions defaults;
  node.declare_parameter("port", defaults.port,
                         text("serial line of the IMU; /dev/serial/by-id/... is the safest name"));
  node.declare_parameter("baudrate", static_cast<int>(defaults.baudrate),
                         text("speed of the line; a new WT901 has 9600, 100 Hz need 115200"));
  declare_frame_prefix(node);
  node.declare_parameter("frame_id", defaults.frame_id, text("frame of the sensor's axes"));
  node.declare_parameter("rate", defaults.rate_hz, within("Hz; one of 0.2 0.5 1 2 5 10 20 50 100 125 200", 0.2, 200.0));
  node.declare_parameter("angular_velocity_stddev", defaults.angular_velocity_stddev,
                         within("rad/s; standard deviation of an angular velocity", kLeastStddev, 100.0));
  node.declare_parameter("linear_acceleration_stddev", defaults.linear_acceleration_stddev,
                         within("m/s^2; standard deviation of an acceleration", kLeastStddev, 1000.0));
  node.declare_parameter("orientation_stddev", defaults.orientation_stddev,
                         within("rad; standard deviation of an angle", kLeastStddev, 100.0));
  node.declare_parameter("magnetic_field_stddev", defaults.magnetic_field_stddev,
                         within("T; standard deviation of the magnetic field", kLeastStddev, 1.0));
  node.declare_parameter("magnetic_field_scale", defaults.magnetic_field_scale,
                         within("T per count of the magnetometer", kLeastStddev, 1.0));
  node.declare_parameter("configure_device", defaults.configure_device,
                         text("set the device's rate and output at start"));
  node.declare_parameter("command_pause", to_seconds(defaults.command_pause),
                         within("s after each command to the device", 0.0, 1.0));
  node.declare_parameter("calibrate_gyro", defaults.calibrate_gyro,
                         text("measure the gyro's bias at rest before activation"));
  node.declare_parameter("calibration_samples", static_cast<int>(defaults.calibration_samples),
                         ParameterDescriptor{.description = "readings of the gyro that the bias is the mean of",
                                             .integer_range = IntegerRange{2, 100000}});
  node.declare_parameter("calibration_max_stddev", defaults.calibration_max_stddev,
                         within("rad/s; more scatter means that the robot moves", 0.0, 100.0));
  node.declare_parameter("calibration_max_bias", defaults.calibration_max_bias,
                         within("rad/s; more means that the robot turns", 0.0, 100.0));
  node.declare_parameter("port_timeout", to_seconds(defaults.port_timeout),
                         within("s to wait for the port to appear, with required_device", 0.0, 3600.0));
  node.declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                         within("s without a sample that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(node);
}

Result<ImuOptions, Problem> read_imu_parameters(const Node& node) {
  ImuOptions options;
  options.port = node.get<std::string>("port");
  if (options.port.empty()) return err(refusal(node, "port", "is empty", "give the IMU's line, e.g. /dev/ttyUSB0"));
  const auto baud = node.get<std::int64_t>("baudrate");
  if (baud <= 0 || baud > 4'000'000 || !io::is_standard_baud(static_cast<unsigned>(baud))) {
    return err(refusal(node, "baudrate", fmt::format("{} is not a standard baud rate", baud),
                       "a WT901 speaks 9600, or 115200 once it was set"));
  }
  options.baudrate = static_cast<unsigned>(baud);
  options.frame_id = frame_name(node, "frame_id");
  if (options.frame_id.empty())
    return err(refusal(node, "frame_id", "is empty", "the axes need a frame; imu_link is the default"));
  options.rate_hz = node.get<double>("rate");
  if (!rate_command(options.rate_hz)) {
    return err(refusal(node, "rate", fmt::format("the device has no rate of {} Hz", options.rate_hz),
                       "it has 0.2 0.5 1 2 5 10 20 50 100 125 and 200"));
  }
  // 55 bytes a sample: at 9600 baud 17 samples/s are all that fits.
  const double fits_hz = static_cast<double>(options.baudrate) / 10.0 / 55.0;
  if (options.rate_hz > fits_hz) {
    return err(refusal(node, "rate", fmt::format("{} Hz need more than {} baud", options.rate_hz, options.baudrate),
                       fmt::format("at most {:.0f} Hz fit, or give the device and baudrate a faster line", fits_hz)));
  }
  options.angular_velocity_stddev = node.get<double>("angular_velocity_stddev");
  options.linear_acceleration_stddev = node.get<double>("linear_acceleration_stddev");
  options.orientation_stddev = node.get<double>("orientation_stddev");
  options.magnetic_field_stddev = node.get<double>("magnetic_field_stddev");
  options.magnetic_field_scale = node.get<double>("magnetic_field_scale");
  options.configure_device = node.get<bool>("configure_device");
  options.command_pause = from_seconds(node.get<double>("command_pause"));
  options.calibrate_gyro = node.get<bool>("calibrate_gyro");
  options.calibration_samples = static_cast<std::size_t>(node.get<std::int64_t>("calibration_samples"));
  options.calibration_max_stddev = node.get<double>("calibration_max_stddev");
  options.calibration_max_bias = node.get<double>("calibration_max_bias");
  options.port_timeout = from_seconds(node.get<double>("port_timeout"));
  options.silence_limit = from_seconds(node.get<double>("silence_limit"));
  auto device = read_device_parameters(node);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

}  // namespace nacelle::imu
