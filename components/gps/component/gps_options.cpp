// SPDX-License-Identifier: Apache-2.0
#include "gps/component/gps_options.hpp"

#include <fmt/format.h>

#include "nacelle/io/serial_port.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::gps {
namespace {

constexpr std::array kQualities{"no fix",         "a fix without corrections",
                                "DGPS or SBAS",   "PPS",
                                "RTK, fixed",     "RTK, float",
                                "dead reckoning", "set by hand",
                                "simulated",      "WAAS"};

ParameterDescriptor text(std::string description) { return {.description = std::move(description)}; }
ParameterDescriptor within(std::string description, double from, double to) {
  return {.description = std::move(description), .floating_point_range = FloatingPointRange{from, to}};
}

Problem refusal(const Node& node, const char* parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter, node.get_fully_qualified_name()), std::move(what), std::move(way_out)};
}

std::string error_name(std::size_t quality) { return fmt::format("epe_quality{}", quality); }

}  // namespace

void declare_gps_parameters(Node& node) {
  const GpsOptions defaults;
  node.declare_parameter("port", defaults.port,
                         text("serial line of the receiver; /dev/serial/by-id/... is the safest name"));
  node.declare_parameter(
      "baud", static_cast<int>(defaults.baud),
      text("speed of the line; most receivers have 9600, older ones 4800; a USB receiver ignores it"));
  declare_frame_prefix(node);
  node.declare_parameter("frame_id", defaults.frame_id, text("frame of the antenna"));
  node.declare_parameter("time_ref_source", defaults.time_ref_source,
                         text("source in time_reference; empty: frame_id"));
  for (std::size_t quality = 0; quality < defaults.errors_m.size(); ++quality) {
    node.declare_parameter(
        error_name(quality), defaults.errors_m[quality],
        within(fmt::format("m, standard deviation at HDOP 1 of quality {} ({})", quality, kQualities[quality]), 1e-3,
               1e7));
  }
  node.declare_parameter("port_timeout", to_seconds(defaults.port_timeout),
                         within("s to wait for the port to appear, with required_device", 0.0, 3600.0));
  node.declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                         within("s without a sentence that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(node);
}

Result<GpsOptions, Problem> read_gps_parameters(const Node& node) {
  GpsOptions options;
  options.port = node.get<std::string>("port");
  if (options.port.empty())
    return err(refusal(node, "port", "is empty", "give the receiver's line, e.g. /dev/ttyACM0"));
  const auto baud = node.get<std::int64_t>("baud");
  if (baud <= 0 || baud > 4'000'000 || !io::is_standard_baud(static_cast<unsigned>(baud))) {
    return err(refusal(node, "baud", fmt::format("{} is not a standard baud rate", baud),
                       "usual ones are 4800, 9600, 38400 and 115200"));
  }
  options.baud = static_cast<unsigned>(baud);
  options.frame_id = frame_name(node, "frame_id");
  if (options.frame_id.empty())
    return err(refusal(node, "frame_id", "is empty", "a fix without a frame cannot be placed; gps is the default"));
  options.time_ref_source = node.get<std::string>("time_ref_source");
  if (options.time_ref_source.empty()) options.time_ref_source = options.frame_id;
  for (std::size_t quality = 0; quality < options.errors_m.size(); ++quality)
    options.errors_m[quality] = node.get<double>(error_name(quality));
  options.port_timeout = from_seconds(node.get<double>("port_timeout"));
  options.silence_limit = from_seconds(node.get<double>("silence_limit"));
  auto device = read_device_parameters(node);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

}  // namespace nacelle::gps
