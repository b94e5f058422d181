// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/device_watch.hpp"

#include <fmt/format.h>

#include <utility>

namespace nacelle {

void declare_device_parameters(Node& node) {
  ParameterDescriptor lost;
  lost.description = "wait (an open fault until the device is back) or fault (on_fault is applied)";
  node.declare_parameter("device_lost", "wait", std::move(lost));
  ParameterDescriptor required;
  required.description = "true: a device that is absent at bring-up fails the configuration";
  node.declare_parameter("required_device", false, std::move(required));
}

Result<DeviceOptions, Problem> read_device_parameters(const Node& node) {
  DeviceOptions options;
  const auto lost = node.get<std::string>("device_lost");
  if (lost != "wait" && lost != "fault") {
    return err(Problem{Place::of_parameter("device_lost", node.get_fully_qualified_name()),
                       fmt::format("'{}' is not known", lost), suggestion(lost, {"wait", "fault"})});
  }
  options.lost = lost == "fault" ? DeviceLost::Fault : DeviceLost::Wait;
  options.required = node.get<bool>("required_device");
  return options;
}

DeviceWatch::DeviceWatch(LifecycleNode& node, const DeviceOptions& options, Settings settings, MonotonicTime now)
    : node_(node), options_(options), settings_(std::move(settings)), last_(now) {}

DeviceWatch::~DeviceWatch() {
  if (is_lost() && options_.lost == DeviceLost::Wait) node_.close_fault(kDeviceLost);
}

void DeviceWatch::lose(const std::string& why) {
  if (is_lost() && why == why_) return;
  why_ = why;
  lost_.store(true, std::memory_order_relaxed);
  const std::string text = fmt::format("{}: {}", settings_.device, why);
  if (options_.lost == DeviceLost::Wait) return node_.open_fault(kDeviceLost, text);
  node_.get_logger().warn("{}; trying to open it again", text);
}

bool DeviceWatch::is_overdue(MonotonicTime now) const {
  if (options_.lost == DeviceLost::Fault) return !faulted_ && now - last_ > settings_.fault_after;
  return !is_lost() && now - last_ > settings_.silence;
}

void DeviceWatch::tell_silence(MonotonicTime now, const std::string& account) {
  const std::string why = fmt::format("silent for {:.1f} s ({}); is it connected and powered, and is this its line?",
                                      to_seconds(now - last_), account);
  if (options_.lost == DeviceLost::Wait) return lose(why);
  faulted_ = true;  // told once; what comes ends it
  node_.fault(settings_.fault_code, fmt::format("{}: {}", settings_.device, why));
}

void DeviceWatch::end_loss() {
  lost_.store(false, std::memory_order_relaxed);
  why_.clear();
  if (options_.lost == DeviceLost::Wait) {
    node_.close_fault(kDeviceLost);
  } else {
    node_.get_logger().info("{}: it is back", settings_.device);
  }
}

}  // namespace nacelle
