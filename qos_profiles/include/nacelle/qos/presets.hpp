// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/qos/qos.hpp"

namespace nacelle {

// ROS 2's presets. Source: rmw/qos_profiles.h, rcl/logging_rosout.h, rcl_action/default_qos.h, rclcpp/qos.cpp,
// tf2_ros/qos.hpp (jazzy). Each is a QoS and nothing more, so that it may be passed and changed like one.

/// keep_last 5, best_effort, volatile.
struct SensorDataQoS : QoS {
  explicit SensorDataQoS(QoS base = QoS(5)) : QoS(base.best_effort().durability_volatile()) {}
};
/// Everything is left to resolved().
struct SystemDefaultsQoS : QoS {
  SystemDefaultsQoS();
};
/// keep_last 10, reliable, volatile.
struct ServicesQoS : QoS {
  explicit ServicesQoS(QoS base = QoS(10)) : QoS(base) {}
};
/// keep_last 1000, reliable, volatile: the parameter services.
struct ParametersQoS : QoS {
  explicit ParametersQoS(QoS base = QoS(1000)) : QoS(base) {}
};
/// keep_last 1000, reliable, volatile: /parameter_events.
struct ParameterEventsQoS : QoS {
  explicit ParameterEventsQoS(QoS base = QoS(1000)) : QoS(base) {}
};
/// keep_last 1000, reliable, transient_local, lifespan 10 s: /rosout.
struct RosoutQoS : QoS {
  explicit RosoutQoS(QoS base = QoS(1000)) : QoS(base.transient_local().lifespan(10s)) {}
};
/// keep_last 1, best_effort, volatile: a reader of /clock.
struct ClockQoS : QoS {
  explicit ClockQoS(QoS base = QoS(1)) : QoS(base.best_effort()) {}
};
/// keep_last 1, reliable, transient_local: an action's status topic.
struct ActionStatusQoS : QoS {
  explicit ActionStatusQoS(QoS base = QoS(1)) : QoS(base.transient_local()) {}
};
/// keep_last 100, reliable, volatile: both sides of /tf.
struct DynamicTransformQoS : QoS {
  explicit DynamicTransformQoS(QoS base = QoS(100)) : QoS(base) {}
};
/// keep_last 1, reliable, transient_local: the writer of /tf_static.
struct StaticTransformQoS : QoS {
  explicit StaticTransformQoS(QoS base = QoS(1)) : QoS(base.transient_local()) {}
};
/// keep_last 100, reliable, transient_local: a reader of /tf_static, which has one message from each of many writers.
struct StaticTransformListenerQoS : QoS {
  explicit StaticTransformListenerQoS(QoS base = QoS(100)) : QoS(base.transient_local()) {}
};
/// keep_last 10; reliability, durability, liveliness, deadline and lease follow the other side.
struct BestAvailableQoS : QoS {
  explicit BestAvailableQoS(QoS base = QoS(10));
};

/// The preset with rmw's name ("sensor_data", "services_default", ...), for files; nothing if there is none.
[[nodiscard]] std::optional<QoS> preset(std::string_view name);
/// The names that preset() knows.
[[nodiscard]] const std::vector<std::string>& preset_names();

}  // namespace nacelle
