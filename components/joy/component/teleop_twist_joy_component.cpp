// SPDX-License-Identifier: Apache-2.0
#include "joy/component/teleop_twist_joy_component.hpp"

#include <utility>
#include <vector>

namespace nacelle::joy {
namespace {

ParameterDescriptor described(std::string description) { return {.description = std::move(description)}; }

struct NamedDirection {
  const char* kind;  // axis_KIND.NAME, scale_KIND.NAME, scale_KIND_turbo.NAME
  const char* name;
  const char* unit;
  TwistMap::Direction TwistMap::Settings::*direction;
};
constexpr std::array kDirections{NamedDirection{"linear", "x", "m/s", &TwistMap::Settings::x},
                                 NamedDirection{"linear", "y", "m/s", &TwistMap::Settings::y},
                                 NamedDirection{"linear", "z", "m/s", &TwistMap::Settings::z},
                                 NamedDirection{"angular", "yaw", "rad/s", &TwistMap::Settings::yaw},
                                 NamedDirection{"angular", "pitch", "rad/s", &TwistMap::Settings::pitch},
                                 NamedDirection{"angular", "roll", "rad/s", &TwistMap::Settings::roll}};

std::string axis_name(const NamedDirection& d) { return std::string("axis_") + d.kind + "." + d.name; }
std::string scale_name(const NamedDirection& d) { return std::string("scale_") + d.kind + "." + d.name; }
std::string turbo_name(const NamedDirection& d) { return std::string("scale_") + d.kind + "_turbo." + d.name; }

void fill(geometry_msgs::msg::Twist& message, const PadTwist& twist) {
  message.linear.x = twist.x;
  message.linear.y = twist.y;
  message.linear.z = twist.z;
  message.angular.x = twist.roll;
  message.angular.y = twist.pitch;
  message.angular.z = twist.yaw;
}

}  // namespace

TeleopTwistJoyComponent::TeleopTwistJoyComponent(const NodeOptions& options)
    : LifecycleNode("teleop_twist_joy_node", options), map_({}) {
  const TwistMap::Settings defaults;
  declare_parameter("require_enable_button", defaults.require_enable_button,
                    described("false: the axes drive without a button"));
  declare_parameter("enable_button", defaults.enable_button,
                    described("index of the button that enables motion while held"));
  declare_parameter("enable_turbo_button", defaults.turbo_button,
                    described("index of the button that enables fast motion while held; -1: none"));
  declare_parameter("inverted_reverse", defaults.inverted_reverse,
                    described("true: yaw is the other way round while driving backwards, as with a car's wheel"));
  for (const NamedDirection& d : kDirections) {
    const TwistMap::Direction& direction = defaults.*d.direction;
    const std::string what = std::string(d.kind) + " velocity " + d.name;
    declare_parameter(axis_name(d), direction.axis, described("index of the axis for " + what + "; -1: none"));
    declare_parameter(scale_name(d), direction.scale, described(std::string(d.unit) + " at the axis' end, " + what));
    declare_parameter(turbo_name(d), direction.turbo_scale,
                      described(std::string(d.unit) + " at the axis' end with the turbo button, " + what));
  }
  declare_parameter("publish_stamped_twist", false,
                    {.description = "true: TwistStamped instead of Twist", .read_only = true});
  declare_parameter("frame", "teleop_twist_joy", {.description = "frame_id of a TwistStamped", .read_only = true});
  frame_ = get<std::string>("frame");
  map_ = TwistMap{read_settings()};
  // Within the callback the values are the old ones.
  on_set_ = add_on_set_parameters_callback([this](const std::vector<Parameter>&) {
    settings_changed_ = true;
    return SetParametersResult{};
  });
  if (get<bool>("publish_stamped_twist")) {
    stamped_ = create_publisher<geometry_msgs::msg::TwistStamped>("cmd_vel", QoS(10));
  } else {
    twist_ = create_publisher<geometry_msgs::msg::Twist>("cmd_vel", QoS(10));
  }
  joy_ = create_subscription<sensor_msgs::msg::Joy>("joy", QoS(10),
                                                    [this](const sensor_msgs::msg::Joy& joy) { on_joy(joy); });
  add_gate_listener(*this);
}

TwistMap::Settings TeleopTwistJoyComponent::read_settings() const {
  TwistMap::Settings settings;
  settings.require_enable_button = get<bool>("require_enable_button");
  settings.enable_button = get<std::int64_t>("enable_button");
  settings.turbo_button = get<std::int64_t>("enable_turbo_button");
  settings.inverted_reverse = get<bool>("inverted_reverse");
  for (const NamedDirection& d : kDirections) {
    settings.*d.direction = {get<std::int64_t>(axis_name(d)), get<double>(scale_name(d)), get<double>(turbo_name(d))};
  }
  return settings;
}

void TeleopTwistJoyComponent::on_joy(const sensor_msgs::msg::Joy& joy) {
  if (std::exchange(settings_changed_, false)) map_ = TwistMap{read_settings()};
  const auto outcome = map_.of({joy.axes.data(), joy.axes.size()}, {joy.buttons.data(), joy.buttons.size()});
  if (!outcome.enabled && is_stopped_) return;
  publish(outcome.twist);
  is_stopped_ = !outcome.enabled;
}

void TeleopTwistJoyComponent::publish(const PadTwist& twist) {
  if (stamped_) {
    auto message = stamped_->borrow();
    if (!message) return;  // every pooled message is still being read; the publisher counted it
    message->header.stamp = now();
    message->header.frame_id = frame_;
    fill(message->twist, twist);
    stamped_->publish(std::move(message));
  } else {
    auto message = twist_->borrow();
    if (!message) return;
    fill(*message, twist);
    twist_->publish(std::move(message));
  }
}

void TeleopTwistJoyComponent::before_gate_closes() noexcept {
  if (!is_stopped_) publish({});
  is_stopped_ = true;
}

}  // namespace nacelle::joy
