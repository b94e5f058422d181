// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "lidar/protocol/ld_protocol.hpp"
#include "lidar/protocol/rplidar_protocol.hpp"
#include "lidar/protocol/ydlidar_protocol.hpp"
#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::lidar {
namespace {

ParameterDescriptor text(std::string description) { return {.description = std::move(description)}; }
ParameterDescriptor fixed(std::string description) {
  return {.description = std::move(description), .read_only = true};
}
ParameterDescriptor within(std::string description, double from, double to) {
  return {.description = std::move(description), .floating_point_range = FloatingPointRange{from, to}};
}

Problem refusal(const Node& node, const char* parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter, node.get_fully_qualified_name()), std::move(what), std::move(way_out)};
}

std::string model_names() {
  std::string names;
  for (const LidarModel& model : lidar_models()) names += (names.empty() ? "" : ", ") + std::string(model.name);
  return names;
}

/// The model that the two parameters name. Both may be given if they mean the same.
Result<LidarModel, Problem> read_model(const Node& node) {
  const auto name = node.get<std::string>("model"), product = node.get<std::string>("product_name");
  std::vector<std::string> names, products;
  for (const LidarModel& model : lidar_models()) {
    names.emplace_back(model.name);
    if (!model.product_name.empty()) products.emplace_back(model.product_name);
  }
  const LidarModel* const model = find_lidar_model(name);
  if (model == nullptr) {
    return err(refusal(node, "model", fmt::format("'{}' is not known", name),
                       fmt::format("{} ({})", suggestion(name, names), model_names())));
  }
  if (product.empty()) return *model;
  const LidarModel* const made = find_lidar_product(product);
  if (made == nullptr)
    return err(refusal(node, "product_name", fmt::format("'{}' is not known", product), suggestion(product, products)));
  if (model != made && model != &lidar_models().front()) {
    return err(refusal(node, "product_name", fmt::format("'{}' is not the model {}", product, name),
                       "give one of the two: model is enough"));
  }
  return *made;
}

/// "10, 20, 350, 370": pairs of angles.
std::optional<std::vector<Sector>> read_sectors(const std::string& text) {
  std::vector<double> angles;
  for (std::size_t at = 0; at < text.size();) {
    at = text.find_first_not_of(" \t", at);
    if (at == std::string::npos) break;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + text.size(), value);
    if (error != std::errc{} || !(value >= -360.0 && value <= 720.0)) return std::nullopt;
    angles.push_back(value);
    at = text.find_first_not_of(" \t", static_cast<std::size_t>(end - text.data()));
    if (at == std::string::npos) break;
    if (text[at] != ',') return std::nullopt;
    ++at;
  }
  if (angles.size() % 2 != 0) return std::nullopt;
  std::vector<Sector> sectors;
  for (std::size_t i = 0; i < angles.size(); i += 2) {
    if (angles[i] > angles[i + 1]) return std::nullopt;
    sectors.push_back({angles[i], angles[i + 1]});
  }
  return sectors;
}

}  // namespace

void declare_lidar_parameters(Node& node) {
  node.declare_parameter("model", std::string(lidar_models().front().name),
                         fixed(fmt::format("the LiDAR: {}; the defaults of port_baudrate, scan_points, range_min and "
                                           "range_max are the model's",
                                           model_names())));
  node.declare_parameter("product_name", std::string{},
                         fixed("the model as LDROBOT's driver names it, such as LDLiDAR_LD06; empty: model counts"));
  LidarOptions defaults;
  // What is wrong with the two above is reported with the others.
  if (const auto model = read_model(node)) defaults.model = *model;
  const LidarModel& model = defaults.model;
  node.declare_parameter("port_name", defaults.port_name,
                         text("serial line of the LiDAR; /dev/serial/by-id/... is the safest name"));
  node.declare_parameter("port_baudrate", static_cast<int>(model.baud),
                         text("speed of the line (baud); an LD06 has 230400"));
  declare_frame_prefix(node);
  node.declare_parameter("frame_id", defaults.frame_id, text("frame of the scans: x to the device's front mark, z up"));
  node.declare_parameter("topic_name", defaults.topic_name,
                         ParameterDescriptor{.description = "topic of the scans", .read_only = true});
  node.declare_parameter(
      "scan_mode", std::string{},
      text("RPLIDAR: Standard, Express, Boost, ..., as the device names its modes; empty: the one it "
           "recommends"));
  node.declare_parameter("laser_scan_dir", true,
                         text("true: counter-clockwise as REP 103 asks; false: clockwise as the device turns"));
  node.declare_parameter("enable_angle_crop_func", false,
                         text("leave out the angles between angle_crop_min and angle_crop_max"));
  node.declare_parameter("angle_crop_min", defaults.scan.crop_min_deg,
                         within("deg, clockwise from the front mark", 0.0, 360.0));
  node.declare_parameter("angle_crop_max", defaults.scan.crop_max_deg,
                         within("deg, clockwise from the front mark", 0.0, 360.0));
  node.declare_parameter(
      "ignore_array", std::string{},
      text("angles to leave out, as pairs in deg counter-clockwise from the scan's x axis: '-10, 10, 170, 190'"));
  node.declare_parameter(
      "angle_offset", 0.0,
      within("deg, counter-clockwise: turns the scan in its frame; 180 if x points away from the front mark", -360.0,
             360.0));
  node.declare_parameter("range_min", model.range_min_m, within("m; nearer is -Inf", 0.0, 65.0));
  node.declare_parameter("range_max", model.range_max_m, within("m; farther is +Inf", 0.0, 65.0));
  node.declare_parameter(
      "scan_points", static_cast<int>(model.scan_points),
      ParameterDescriptor{.description = "rays of every scan, whatever the speed; 450 is one turn of an "
                                         "LD06 at 10 Hz",
                          .integer_range = IntegerRange{1, 36000}});
  node.declare_parameter("port_timeout", to_seconds(defaults.port_timeout),
                         within("s to wait for the port to appear, with required_device", 0.0, 3600.0));
  node.declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                         within("s without a frame that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(node);
}

Result<LidarOptions, Problem> read_lidar_parameters(const Node& node) {
  LidarOptions options;
  const auto model = read_model(node);
  if (!model) return err(model.error());
  options.model = *model;
  options.port_name = node.get<std::string>("port_name");
  if (options.port_name.empty())
    return err(refusal(node, "port_name", "is empty", "give the LiDAR's line, e.g. /dev/ttyUSB0"));
  const auto baud = node.get<std::int64_t>("port_baudrate");
  if (baud <= 0 || baud > 4'000'000 || !io::is_standard_baud(static_cast<unsigned>(baud))) {
    return err(refusal(node, "port_baudrate", fmt::format("{} is not a standard baud rate", baud),
                       fmt::format("model {} speaks {}", options.model.name, options.model.baud)));
  }
  options.port_baudrate = static_cast<unsigned>(baud);
  options.frame_id = frame_name(node, "frame_id");
  if (options.frame_id.empty())
    return err(
        refusal(node, "frame_id", "is empty", "a scan without a frame cannot be placed; lidar_link is the default"));
  options.topic_name = node.get<std::string>("topic_name");
  options.scan_mode = node.get<std::string>("scan_mode");
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
  const auto ignored = node.get<std::string>("ignore_array");
  auto sectors = read_sectors(ignored);
  if (!sectors) {
    return err(refusal(node, "ignore_array", fmt::format("'{}' is not a list of pairs of angles", ignored),
                       "give from and to of each sector in deg, such as '-10, 10, 170, 190'"));
  }
  options.scan.ignored = std::move(*sectors);
  options.scan.offset_deg = node.get<double>("angle_offset");
  options.scan.range_min_m = node.get<double>("range_min");
  options.scan.range_max_m = node.get<double>("range_max");
  if (options.scan.range_min_m >= options.scan.range_max_m) {
    return err(
        refusal(node, "range_min",
                fmt::format("{} m is not below range_max {} m", options.scan.range_min_m, options.scan.range_max_m),
                fmt::format("model {} measures from {} to {}", options.model.name, options.model.range_min_m,
                            options.model.range_max_m)));
  }
  options.scan.points = static_cast<std::size_t>(node.get<std::int64_t>("scan_points"));
  options.port_timeout = from_seconds(node.get<double>("port_timeout"));
  options.silence_limit = from_seconds(node.get<double>("silence_limit"));
  auto device = read_device_parameters(node);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

std::unique_ptr<LidarProtocol> make_protocol(const LidarOptions& options) {
  if (options.model.family == LidarFamily::Rplidar) return std::make_unique<RplidarProtocol>(options.scan_mode);
  if (options.model.family == LidarFamily::Ydlidar) {
    return std::make_unique<YdlidarProtocol>(YdlidarProtocol::Settings{
        options.model.points_per_second, options.model.has_intensities, options.model.is_commanded});
  }
  return std::make_unique<LdProtocol>(options.model.points_per_second);
}

}  // namespace nacelle::lidar
