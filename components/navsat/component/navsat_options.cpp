// SPDX-License-Identifier: Apache-2.0
#include "navsat/component/navsat_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nacelle/node/frame_name.hpp"

namespace nacelle::navsat {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

ParameterDescriptor text(std::string description) { return {.description = std::move(description), .read_only = true}; }
ParameterDescriptor within(std::string description, double from, double to) {
  return {
      .description = std::move(description), .read_only = true, .floating_point_range = FloatingPointRange{from, to}};
}

}  // namespace

void declare_navsat_parameters(Node& node) {
  const NavsatOptions d;
  node.declare_parameter("frequency", d.frequency_hz,
                         within("Outputs per second at the most, Hz. A fix is published once.", 0.01, 1000.0));
  node.declare_parameter("delay", 0.0, within("s after activation before the frames are aligned", 0.0, 3600.0));
  node.declare_parameter("magnetic_declination_radians", 0.0,
                         within("rad added to the heading. Positive where magnetic north lies west of true north, as "
                                "in robot_localization; maps and NOAA count east.",
                                -kTurn, kTurn));
  node.declare_parameter("yaw_offset", 0.0,
                         within("rad added to the heading: pi/2 if the sensor reads 0 towards north", -kTurn, kTurn));
  node.declare_parameter("zero_altitude", d.zero_altitude, text("z of odometry/gps is 0: for a robot on a plane."));
  node.declare_parameter("publish_filtered_gps", d.publish_filtered_gps,
                         text("Publish odometry/filtered as a fix on gps/filtered."));
  node.declare_parameter("use_odometry_yaw", d.use_odometry_yaw,
                         text("The heading is that of odometry/filtered, which must be one from true north; imu is "
                              "not read."));
  node.declare_parameter("wait_for_datum", d.wait_for_datum,
                         text("The world's origin is a datum, of the parameter or of the service; imu is not read."));
  node.declare_parameter("datum", std::vector<double>{},
                         text("Latitude and longitude (degrees) of the world's origin, and the heading of its x axis "
                              "(rad from east), with wait_for_datum."));
  node.declare_parameter("use_local_cartesian", d.use_local_cartesian,
                         text("Project onto a plane that touches the Earth at the datum, instead of onto UTM."));
  node.declare_parameter("broadcast_cartesian_transform", d.broadcasts_cartesian,
                         text("Broadcast the frame utm, or local_enu, below the world's frame."));
  node.declare_parameter("broadcast_cartesian_transform_as_parent_frame", d.cartesian_is_parent,
                         text("Broadcast it above the world's frame instead."));
  node.declare_parameter("broadcast_utm_transform", false, text("An older name of broadcast_cartesian_transform."));
  node.declare_parameter("broadcast_utm_transform_as_parent_frame", false,
                         text("An older name of broadcast_cartesian_transform_as_parent_frame."));
  node.declare_parameter("transform_timeout", 0.0,
                         text("Kept for robot_localization's files: transforms are taken as they are, nothing waits."));
  node.declare_parameter("stddev_if_unknown", d.stddev_if_unknown_m,
                         within("m, of fixes without a covariance; twice that up", 1e-3, 1e7));
  declare_frame_prefix(node);
}

Result<NavsatOptions, Problem> read_navsat_parameters(const Node& node) {
  NavsatOptions options;
  options.frequency_hz = node.get<double>("frequency");
  options.delay = from_seconds(node.get<double>("delay"));
  options.heading.declination_rad = node.get<double>("magnetic_declination_radians");
  options.heading.yaw_offset_rad = node.get<double>("yaw_offset");
  options.zero_altitude = node.get<bool>("zero_altitude");
  options.publish_filtered_gps = node.get<bool>("publish_filtered_gps");
  options.use_odometry_yaw = node.get<bool>("use_odometry_yaw");
  options.wait_for_datum = node.get<bool>("wait_for_datum");
  options.use_local_cartesian = node.get<bool>("use_local_cartesian");
  options.broadcasts_cartesian =
      node.get<bool>("broadcast_cartesian_transform") || node.get<bool>("broadcast_utm_transform");
  options.cartesian_is_parent = node.get<bool>("broadcast_cartesian_transform_as_parent_frame") ||
                                node.get<bool>("broadcast_utm_transform_as_parent_frame");
  options.stddev_if_unknown_m = node.get<double>("stddev_if_unknown");
  options.cartesian_frame = with_frame_prefix(node.get<std::string>(kFramePrefixParameter),
                                              options.use_local_cartesian ? "local_enu" : "utm");
  const auto datum = node.get<std::vector<double>>("datum");
  if (datum.empty()) return options;
  const auto place = Place::of_parameter("datum", node.get_fully_qualified_name());
  if (datum.size() != 3) {
    return err(Problem{place, fmt::format("has {} numbers", datum.size()),
                       "give latitude and longitude in degrees and the heading in rad: [55.944904, -3.186693, 0.0]"});
  }
  if (!check_position(datum[0], datum[1]) || !std::isfinite(datum[2])) {
    return err(Problem{place, fmt::format("[{}] is no place on the Earth", fmt::join(datum, ", ")),
                       "the first number is the latitude (-90 to 90), the second the longitude (-180 to 180), in "
                       "degrees; the third the heading in rad"});
  }
  options.datum = ManualDatum{{datum[0], datum[1], 0.0}, spatial::quaternion_from_yaw(datum[2])};
  return options;
}

}  // namespace nacelle::navsat
