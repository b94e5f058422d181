// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "imu/component/chip_setup.hpp"
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

std::string model_names() {
  std::vector<std::string_view> names;
  for (const auto& model : imu_models()) names.push_back(model.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// What a sensor of this noise density scatters by, in half the band of its rate; as printed, three digits say enough.
double scatter(double density, double rate_hz) {
  const double exact = density * std::sqrt(rate_hz / 2.0);
  const double digits = std::pow(10.0, 2.0 - std::floor(std::log10(exact)));
  return std::round(exact * digits) / digits;
}

int preferred(std::span<const int> ranges, int wanted) {
  const auto found = std::ranges::find_if(ranges, [&](int range) { return range >= wanted; });
  return found == ranges.end() ? 0 : *found;
}

/// Errors: as read_imu_parameters().
template <std::size_t N>
Result<std::array<double, N>, Problem> numbers(const Node& node, const char* parameter) {
  const auto values = node.get<std::vector<double>>(parameter);
  std::array<double, N> all{};
  const bool are_finite = std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
  if (values.size() != N || !are_finite) {
    return err(refusal(node, parameter, fmt::format("is [{}]", fmt::join(values, ", ")),
                       fmt::format("give {} finite numbers", N)));
  }
  std::ranges::copy(values, all.begin());
  return all;
}

template <typename Array>
std::vector<double> listed(const Array& values) {
  return {values.begin(), values.end()};
}

void declare_corrections(Node& node) {
  const SampleCorrection none;
  node.declare_parameter("mounting_rpy", listed(none.mounting_rpy_rad),
                         text("rad; roll, pitch, yaw of the sensor's axes in frame_id, about fixed axes"));
  node.declare_parameter("gyro_bias", listed(none.gyro_bias_rps),
                         text("rad/s; taken off the angular velocity, in the sensor's axes"));
  node.declare_parameter("accel_bias", listed(none.acceleration_bias_mps2),
                         text("m/s^2; taken off the acceleration, in the sensor's axes"));
  node.declare_parameter("accel_matrix", listed(none.acceleration_matrix),
                         text("9 numbers, row by row: multiplied with the acceleration after its bias is off"));
  node.declare_parameter("mag_bias", listed(none.field_bias_t),
                         text("T; taken off the magnetic field (hard iron), in the sensor's axes"));
  node.declare_parameter("mag_matrix", listed(none.field_matrix),
                         text("9 numbers, row by row: multiplied with the field after its bias is off (soft iron)"));
}

Result<SampleCorrection, Problem> read_corrections(const Node& node) {
  SampleCorrection correction;
  const std::pair<const char*, Vector3*> vectors[] = {{"mounting_rpy", &correction.mounting_rpy_rad},
                                                      {"gyro_bias", &correction.gyro_bias_rps},
                                                      {"accel_bias", &correction.acceleration_bias_mps2},
                                                      {"mag_bias", &correction.field_bias_t}};
  for (const auto& [name, into] : vectors) {
    auto values = numbers<3>(node, name);
    if (!values) return err(values.error());
    *into = *values;
  }
  const std::pair<const char*, Matrix3*> matrices[] = {{"accel_matrix", &correction.acceleration_matrix},
                                                       {"mag_matrix", &correction.field_matrix}};
  for (const auto& [name, into] : matrices) {
    auto values = numbers<9>(node, name);
    if (!values) return err(values.error());
    *into = *values;
  }
  return correction;
}

Result<std::uint8_t, Problem> read_address(const Node& node, const char* parameter) {
  const auto address = node.get<std::int64_t>(parameter);
  if (address >= 0x08 && address <= 0x77) return static_cast<std::uint8_t>(address);
  return err(refusal(node, parameter, fmt::format("{} is no I2C address", address), "it is 8 to 119 (0x08 to 0x77)"));
}

/// Address, ranges and rate of a chip on a register bus.
Result<void, Problem> read_chip(const Node& node, ImuOptions& options) {
  if (options.traits->is_on_i2c) {
    auto address = read_address(node, "address");
    if (!address) return err(address.error());
    options.address = *address;
  }
  if (options.model == ImuModel::Bmi088) {
    auto gyro = read_address(node, "gyro_address");
    if (!gyro) return err(gyro.error());
    options.gyro_address = *gyro;
  }
  if (options.model == ImuModel::Lsm6dsox && node.get<std::int64_t>("mag_address") != 0) {
    auto mag = read_address(node, "mag_address");
    if (!mag) return err(mag.error());
    options.mag_address = *mag;
  }
  options.use_fifo =
      node.get<bool>("use_fifo") && options.model != ImuModel::Bno055 && options.model != ImuModel::Bno055Uart;
  const std::tuple<const char*, std::span<const int>, int*> ranges[] = {
      {"accel_range", options.traits->acceleration_ranges_g, &options.accel_range_g},
      {"gyro_range", options.traits->angular_velocity_ranges_dps, &options.gyro_range_dps}};
  for (const auto& [name, known, into] : ranges) {
    *into = static_cast<int>(node.get<std::int64_t>(name));
    if (!known.empty() && std::ranges::find(known, *into) == known.end()) {
      return err(refusal(node, name, fmt::format("the {} has no range of {}", options.traits->name, *into),
                         fmt::format("it has {}", fmt::join(known, " "))));
    }
  }
  auto rate = chip_rate(options.model, options.rate_hz);
  if (!rate) {
    return err(refusal(node, "rate", fmt::format("the {} has no rate of {} Hz", options.traits->name, options.rate_hz),
                       rate.error()));
  }
  options.rate_hz = *rate;
  return {};
}

/// Baud rate and rate of a device that sends by itself.
Result<void, Problem> read_serial(const Node& node, ImuOptions& options) {
  if (options.model == ImuModel::Wt901) {
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
  } else if (options.rate_hz != options.traits->highest_rate_hz) {
    return err(refusal(node, "rate", fmt::format("a BNO08x sends 100 samples/s in mode RVC, not {}", options.rate_hz),
                       "leave it out"));
  }
  return {};
}

}  // namespace

void declare_imu_parameters(Node& node) {
  ImuOptions defaults;
  const auto name = node.declare_parameter(
      "model", "wt901", ParameterDescriptor{.description = "the device: " + model_names(), .read_only = true});
  // An unknown one is refused by read_imu_parameters().
  const ModelTraits* const found = find_imu_model(name);
  const ModelTraits& traits = found == nullptr ? imu_models().front() : *found;
  const bool is_wt901 = traits.model == ImuModel::Wt901;
  node.declare_parameter("port", traits.is_on_i2c ? "/dev/i2c-1" : defaults.port.c_str(),
                         text("serial line of the IMU, /dev/serial/by-id/... is the safest name; or its I2C bus"));
  node.declare_parameter("baudrate", static_cast<int>(defaults.baudrate),
                         text("speed of a serial line; a new WT901 has 9600, 100 Hz need 115200"));
  const auto address = [&](const char* parameter, int value, const char* what) {
    node.declare_parameter(parameter, value,
                           ParameterDescriptor{.description = what, .integer_range = IntegerRange{0, 0x77}});
  };
  address("address", traits.address, "I2C address of the chip; as delivered by default");
  address("gyro_address", 0x68, "I2C address of a BMI088's gyro");
  address("mag_address", 0x1C, "I2C address of a LIS3MDL beside an LSM6DSOX; 0: there is none");
  node.declare_parameter("accel_range", preferred(traits.acceleration_ranges_g, defaults.accel_range_g),
                         text("g; range of the accelerometer of a chip on I2C"));
  node.declare_parameter("gyro_range", preferred(traits.angular_velocity_ranges_dps, defaults.gyro_range_dps),
                         text("deg/s; range of the gyro of a chip on I2C"));
  node.declare_parameter("use_fifo", defaults.use_fifo,
                         text("read a chip's FIFO, so that no reading is lost; false: its data registers"));
  declare_frame_prefix(node);
  node.declare_parameter("frame_id", defaults.frame_id, text("frame of the sensor's axes"));
  const double rate_hz =
      node.declare_parameter("rate", traits.default_rate_hz,
                             within("Hz; samples per second; which there are depends on the model", 0.2, 1100.0));
  node.declare_parameter("publish_orientation", defaults.publish_orientation,
                         ParameterDescriptor{.description = "publish imu/data, if the device computes the orientation; "
                                                            "false leaves that topic to a filter",
                                             .read_only = true});
  node.declare_parameter("angular_velocity_stddev",
                         is_wt901 ? defaults.angular_velocity_stddev : scatter(traits.angular_velocity_noise, rate_hz),
                         within("rad/s; standard deviation of an angular velocity", kLeastStddev, 100.0));
  node.declare_parameter("linear_acceleration_stddev",
                         is_wt901 ? defaults.linear_acceleration_stddev : scatter(traits.acceleration_noise, rate_hz),
                         within("m/s^2; standard deviation of an acceleration", kLeastStddev, 1000.0));
  node.declare_parameter("orientation_stddev", traits.orientation_stddev,
                         within("rad; standard deviation of an angle", kLeastStddev, 100.0));
  node.declare_parameter("magnetic_field_stddev", traits.magnetic_field_stddev,
                         within("T; standard deviation of the magnetic field", kLeastStddev, 1.0));
  node.declare_parameter("magnetic_field_scale", defaults.magnetic_field_scale,
                         within("T per count of a WT901's magnetometer", kLeastStddev, 1.0));
  declare_corrections(node);
  node.declare_parameter("configure_device", defaults.configure_device, text("set a WT901's rate and output at start"));
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
  const auto name = node.get<std::string>("model");
  options.traits = find_imu_model(name);
  if (options.traits == nullptr)
    return err(refusal(node, "model", fmt::format("'{}' is not supported", name), "it is one of " + model_names()));
  options.model = options.traits->model;
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
  if (options.rate_hz > options.traits->highest_rate_hz) {
    return err(refusal(node, "rate", fmt::format("the {} has no rate of {} Hz", name, options.rate_hz),
                       fmt::format("at most {} Hz", options.traits->highest_rate_hz)));
  }
  const bool sends_by_itself = options.model == ImuModel::Wt901 || options.model == ImuModel::Bno08xRvc;
  if (auto read = sends_by_itself ? read_serial(node, options) : read_chip(node, options); !read)
    return err(read.error());
  auto correction = read_corrections(node);
  if (!correction) return err(correction.error());
  options.correction = *correction;
  options.publish_orientation = options.traits->has_orientation && node.get<bool>("publish_orientation");
  options.angular_velocity_stddev = node.get<double>("angular_velocity_stddev");
  options.linear_acceleration_stddev = node.get<double>("linear_acceleration_stddev");
  options.orientation_stddev = node.get<double>("orientation_stddev");
  options.magnetic_field_stddev = node.get<double>("magnetic_field_stddev");
  options.magnetic_field_scale = node.get<double>("magnetic_field_scale");
  options.configure_device = node.get<bool>("configure_device");
  options.command_pause = from_seconds(node.get<double>("command_pause"));
  options.calibrate_gyro = options.traits->has_angular_velocity && node.get<bool>("calibrate_gyro");
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
