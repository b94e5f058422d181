// SPDX-License-Identifier: Apache-2.0
#include "monitor/component/stream_readers.hpp"

#include <algorithm>
#include <iterator>
#include <type_traits>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "geometry_msgs/msg/pose_array.hpp"
#include "geometry_msgs/msg/pose_stamped.hpp"
#include "geometry_msgs/msg/pose_with_covariance_stamped.hpp"
#include "geometry_msgs/msg/twist.hpp"
#include "geometry_msgs/msg/twist_stamped.hpp"
#include "nacelle/qos/presets.hpp"
#include "nav_msgs/msg/odometry.hpp"
#include "nav_msgs/msg/path.hpp"
#include "sensor_msgs/msg/battery_state.hpp"
#include "sensor_msgs/msg/camera_info.hpp"
#include "sensor_msgs/msg/image.hpp"
#include "sensor_msgs/msg/imu.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "sensor_msgs/msg/joy.hpp"
#include "sensor_msgs/msg/laser_scan.hpp"
#include "sensor_msgs/msg/magnetic_field.hpp"
#include "sensor_msgs/msg/nav_sat_fix.hpp"
#include "sensor_msgs/msg/point_cloud2.hpp"
#include "sensor_msgs/msg/range.hpp"
#include "sensor_msgs/msg/temperature.hpp"
#include "std_msgs/msg/bool.hpp"
#include "std_msgs/msg/float64.hpp"
#include "std_msgs/msg/int32.hpp"
#include "std_msgs/msg/string.hpp"
#include "tf2_msgs/msg/tf_message.hpp"

namespace nacelle::monitor {
namespace {

// A stamp of zero was not set.
std::optional<Duration> age_by(const builtin_interfaces::msg::Time& stamp, WallTime now) {
  if (stamp.sec == 0 && stamp.nanosec == 0) return std::nullopt;
  return now - time_of(stamp);
}

template <typename T>
std::optional<Duration> age_of(const T& message, WallTime now) {
  if constexpr (requires { message.header.stamp; }) {
    return age_by(message.header.stamp, now);
  } else if constexpr (std::is_same_v<T, tf2_msgs::msg::TFMessage>) {
    if (message.transforms.empty()) return std::nullopt;
    return age_by(message.transforms.front().header.stamp, now);
  } else {
    return std::nullopt;
  }
}

template <typename T>
std::shared_ptr<SubscriptionBase> subscribe(Node& node, const std::string& topic, const QoS& qos, ShareAs share_as,
                                            Announced announced, StreamWatch& watch) {
  SubscriptionOptions options;
  options.announced = announced;
  const auto record = [&node, &watch](const T& message, const MessageInfo& info) {
    watch.record(info.received_time, info.writer_id, info.sequence, age_of(message, node.now()));
  };
  if (share_as == ShareAs::Reference) {
    return node.create_subscription<T>(
        topic, qos, [record](const T& message, const MessageInfo& info) { record(message, info); }, options);
  }
  return node.create_subscription<T>(
      topic, qos, [record](std::shared_ptr<const T> message, const MessageInfo& info) { record(*message, info); },
      options);
}

#define NACELLE_READABLE(package, Type) \
  { #package "/msg/" #Type, &subscribe < package::msg::Type> }
const ReadableType kTypes[] = {
    NACELLE_READABLE(diagnostic_msgs, DiagnosticArray),
    NACELLE_READABLE(geometry_msgs, PoseArray),
    NACELLE_READABLE(geometry_msgs, PoseStamped),
    NACELLE_READABLE(geometry_msgs, PoseWithCovarianceStamped),
    NACELLE_READABLE(geometry_msgs, Twist),
    NACELLE_READABLE(geometry_msgs, TwistStamped),
    NACELLE_READABLE(nav_msgs, Odometry),
    NACELLE_READABLE(nav_msgs, Path),
    NACELLE_READABLE(sensor_msgs, BatteryState),
    NACELLE_READABLE(sensor_msgs, CameraInfo),
    NACELLE_READABLE(sensor_msgs, Image),
    NACELLE_READABLE(sensor_msgs, Imu),
    NACELLE_READABLE(sensor_msgs, JointState),
    NACELLE_READABLE(sensor_msgs, Joy),
    NACELLE_READABLE(sensor_msgs, LaserScan),
    NACELLE_READABLE(sensor_msgs, MagneticField),
    NACELLE_READABLE(sensor_msgs, NavSatFix),
    NACELLE_READABLE(sensor_msgs, PointCloud2),
    NACELLE_READABLE(sensor_msgs, Range),
    NACELLE_READABLE(sensor_msgs, Temperature),
    NACELLE_READABLE(std_msgs, Bool),
    NACELLE_READABLE(std_msgs, Float64),
    NACELLE_READABLE(std_msgs, Int32),
    NACELLE_READABLE(std_msgs, String),
    NACELLE_READABLE(tf2_msgs, TFMessage),
};
#undef NACELLE_READABLE

// The robot's standard topics, so that a parameter file need not repeat them.
struct KnownTopic {
  std::string_view topic, type, second_type;
  bool periodic = true;
};
constexpr KnownTopic kTopics[] = {
    {"/camera/image_raw", "sensor_msgs/msg/Image", ""},
    {"/camera/camera_info", "sensor_msgs/msg/CameraInfo", ""},
    {"/detections", "geometry_msgs/msg/PoseArray", ""},
    {"/scan", "sensor_msgs/msg/LaserScan", ""},
    {"/imu/data_raw", "sensor_msgs/msg/Imu", ""},
    {"/imu/data", "sensor_msgs/msg/Imu", ""},
    {"/imu/mag", "sensor_msgs/msg/MagneticField", ""},
    {"/cmd_vel", "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", false},
    {"/joint_states", "sensor_msgs/msg/JointState", ""},
    {"/battery/state", "sensor_msgs/msg/BatteryState", ""},
    {"/odom", "nav_msgs/msg/Odometry", ""},
    {"/odometry/filtered", "nav_msgs/msg/Odometry", ""},
    {"/tf", "tf2_msgs/msg/TFMessage", ""},
    {"/tf_static", "tf2_msgs/msg/TFMessage", "", false},
    {"/robot_description", "std_msgs/msg/String", "", false},
    {"/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", ""},
};

const ReadableType* find_type(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const auto& type) { return name == type.name; });
  return found == std::end(kTypes) ? nullptr : found;
}

// What every writer of such a stream is compatible with: a reader that asks for less is served by all.
QoS qos_for(std::string_view topic, std::string_view type) {
  if (topic.ends_with("/tf_static")) return StaticTransformListenerQoS();
  if (topic.ends_with("/robot_description")) return QoS(1).transient_local();
  // Few images, since each that waits keeps a camera's buffer.
  const bool large = type == "sensor_msgs/msg/Image" || type == "sensor_msgs/msg/PointCloud2";
  return SensorDataQoS(QoS(large ? 2 : 50));
}

std::vector<std::string> names_of_types() {
  std::vector<std::string> names;
  for (const auto& type : kTypes) names.emplace_back(type.name);
  return names;
}
std::vector<std::string> names_of_topics() {
  std::vector<std::string> names;
  for (const auto& known : kTopics) names.emplace_back(known.topic);
  return names;
}

}  // namespace

Result<StreamPlan, Problem> plan_stream(std::string_view entry) {
  const auto first = entry.find_first_not_of(' ');
  if (first == std::string_view::npos)
    return err(Problem{Place::of_parameter("streams"), "an entry is empty", "name a topic, such as /scan"});
  entry.remove_prefix(first);
  entry = entry.substr(0, entry.find_last_not_of(' ') + 1);
  const auto gap = entry.find(' ');
  StreamPlan plan;
  plan.topic = std::string(entry.substr(0, gap));
  const auto* const known = std::find_if(std::begin(kTopics), std::end(kTopics), [&](const auto& topic) {
    return plan.topic == topic.topic || "/" + plan.topic == topic.topic;
  });
  if (known != std::end(kTopics)) plan.periodic = known->periodic;
  if (gap != std::string_view::npos) {
    const std::string type{entry.substr(entry.find_first_not_of(' ', gap))};
    plan.types.push_back(find_type(type));
    if (plan.types[0] == nullptr) {
      return err(Problem{Place::of_parameter("streams"), "of " + plan.topic + " the type '" + type + "' cannot be read",
                         suggestion(type, names_of_types())});
    }
  } else {
    if (known == std::end(kTopics)) {
      const std::string near = nearest_name(plan.topic, names_of_topics());
      return err(Problem{Place::of_parameter("streams"), "the type of " + plan.topic + " is not known",
                         "write it behind the topic, as in '" + plan.topic + " sensor_msgs/msg/LaserScan'" +
                             (near.empty() ? "" : ", or did you mean '" + near + "'?")});
    }
    plan.types.push_back(find_type(known->type));
    if (!known->second_type.empty()) plan.types.push_back(find_type(known->second_type));
  }
  plan.qos = qos_for("/" + plan.topic, plan.types[0]->name);  // one slash more does no harm there
  if (plan.qos.durability() == Durability::TransientLocal) plan.periodic = false;
  return plan;
}

}  // namespace nacelle::monitor
