// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_options.hpp"

#include <fmt/format.h>

#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::lidar {
namespace {

// Of one data format and one point rate; the plausibility check of the frames counts on 4500 points/s.
const std::vector<std::string> kProducts{"LDLiDAR_LD06", "LDLiDAR_LD19"};

ParameterDescriptor text(std::string description) { return {.description = std::move(description)}; }
ParameterDescriptor within(std::string description, double from, double to) {
  return {.description = std::move(description), .floating_point_range = FloatingPointRange{from, to}};
}

Problem refusal(const Node& node, const char* parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter, node.get_fully_qualified_name()), std::move(what), std::move(way_out)};
}

}  // namespace

void declare_lidar_parameters(Node& node) {
  const LidarOptions defaults;
  node.declare_parameter("port_name", defaults.port_name,
                         text("serial line of the LiDAR; /dev/serial/by-id/... is the safest name"));
  node.declare_parameter("port_baudrate", static_cast<int>(defaults.port_baudrate),
                         text("speed of the line; an LD06 has 230400"));
  declare_frame_prefix(node);
  node.declare_parameter("frame_id", defaults.frame_id, text("frame of the scans: x to the device's front mark, z up"));
  node.declare_parameter("topic_name", defaults.topic_name,
                         ParameterDescriptor{.description = "topic of the scans", .read_only = true});
  node.declare_parameter("product_name", defaults.product_name, text("LDLiDAR_LD06 or LDLiDAR_LD19"));
  node.declare_parameter("laser_scan_dir", true,
                         text("true: counter-clockwise as REP 103 asks; false: clockwise as the device turns"));
  node.declare_parameter("enable_angle_crop_func", false,
                         text("leave out the angles between angle_crop_min and angle_crop_max"));
  node.declare_parameter("angle_crop_min", defaults.scan.crop_min_deg,
                         within("deg, clockwise from the front mark", 0.0, 360.0));
  node.declare_parameter("angle_crop_max", defaults.scan.crop_max_deg,
                         within("deg, clockwise from the front mark", 0.0, 360.0));
  node.declare_parameter("range_min", defaults.scan.range_min_m, within("m; nearer is -Inf", 0.0, 65.0));
  node.declare_parameter("range_max", defaults.scan.range_max_m, within("m; farther is +Inf", 0.0, 65.0));
  node.declare_parameter("scan_points", static_cast<int>(defaults.scan.points),
                         ParameterDescriptor{.description = "rays of every scan; 450 is one turn at 10 Hz",
                                             .integer_range = IntegerRange{1, 36000}});
  node.declare_parameter("port_timeout", to_seconds(defaults.port_timeout),
                         within("s to wait for the port to appear, with required_device", 0.0, 3600.0));
  node.declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                         within("s without a frame that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(node);
}

Result<LidarOptions, Problem> read_lidar_parameters(const Node& node) {
  LidarOptions options;
  options.port_name = node.get<std::string>("port_name");
  if (options.port_name.empty())
    return err(refusal(node, "port_name", "is empty", "give the LiDAR's line, e.g. /dev/ttyUSB0"));
  const auto baud = node.get<std::int64_t>("port_baudrate");
  if (baud <= 0 || baud > 4'000'000 || !io::is_standard_baud(static_cast<unsigned>(baud))) {
    return err(
        refusal(node, "port_baudrate", fmt::format("{} is not a standard baud rate", baud), "an LD06 speaks 230400"));
  }
  options.port_baudrate = static_cast<unsigned>(baud);
  options.frame_id = frame_name(node, "frame_id");
  if (options.frame_id.empty())
    return err(
        refusal(node, "frame_id", "is empty", "a scan without a frame cannot be placed; lidar_link is the default"));
  options.topic_name = node.get<std::string>("topic_name");
  options.product_name = node.get<std::string>("product_name");
  if (std::find(kProducts.begin(), kProducts.end(), options.product_name) == kProducts.end()) {
    return err(refusal(node, "product_name", fmt::format("'{}' is not known", options.product_name),
                       suggestion(options.product_name, kProducts)));
  }
  options.scan.counter_clockwise = node.get<bool>("laser_scan_dir");
  options.scan.crop = node.get<bool>("enable_angle_crop_func");
  options.scan.crop_min_deg = node.get<double>("angle_crop_min");
  options.scan.crop_max_deg = node.get<double>("angle_crop_max");
  if (options.scan.crop && options.scan.crop_min_deg > options.scan.crop_max_deg) {
    return err(
        refusal(node, "angle_crop_min",
                fmt::format("{} is above angle_crop_max {}", options.scan.crop_min_deg, options.scan.crop_max_deg),
                "swap them"));
  }
  options.scan.range_min_m = node.get<double>("range_min");
  options.scan.range_max_m = node.get<double>("range_max");
  if (options.scan.range_min_m >= options.scan.range_max_m) {
    return err(
        refusal(node, "range_min",
                fmt::format("{} m is not below range_max {} m", options.scan.range_min_m, options.scan.range_max_m),
                "an LD06 measures from 0.02 to 12"));
  }
  options.scan.points = static_cast<std::size_t>(node.get<std::int64_t>("scan_points"));
  options.port_timeout = from_seconds(node.get<double>("port_timeout"));
  options.silence_limit = from_seconds(node.get<double>("silence_limit"));
  auto device = read_device_parameters(node);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

}  // namespace nacelle::lidar
