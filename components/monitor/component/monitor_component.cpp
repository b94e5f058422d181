// SPDX-License-Identifier: Apache-2.0
#include "monitor/component/monitor_component.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::monitor {
namespace {

ParameterDescriptor fixed(std::string description) {
  return {std::move(description), "", true, false, std::nullopt, std::nullopt};
}
ParameterDescriptor bounded(std::string description, double from, double to) {
  return {std::move(description), "", true, false, std::nullopt, FloatingPointRange{from, to, 0}};
}

void add(diagnostic_msgs::msg::DiagnosticStatus& status, const char* key, std::string value) {
  auto& entry = status.values.emplace_back();
  entry.key = key;
  entry.value = std::move(value);
}

}  // namespace

MonitorComponent::MonitorComponent(const NodeOptions& options) : LifecycleNode("monitor", options) {
  declare_streams();
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", QoS(10));
  const double rate_hz =
      declare_parameter<double>("diagnostics_rate", 1.0, bounded("Reports per second.", 0.01, 100.0));
  timer_ = create_wall_timer(from_seconds(1.0 / rate_hz), [this] { report(); });
}

void MonitorComponent::declare_streams() {
  const auto entries = declare_parameter<std::vector<std::string>>(
      "streams", {}, fixed("Topics to read; 'topic type' where the topic is not one of the robot's own."));
  const auto share =
      declare_parameter<std::string>("share_as", "reference", fixed("How messages are taken: reference or pointer."));
  const auto rates = declare_parameter<std::vector<double>>(
      "expected_rates", {}, fixed("Hz per stream, 0 for any; empty for any everywhere."));
  Expectation common;
  common.tolerance = declare_parameter<double>("rate_tolerance", common.tolerance,
                                               bounded("Share of the expected rate that is tolerated.", 0.0, 1.0));
  common.stale_after = from_seconds(
      declare_parameter<double>("stale_after", 2.0, bounded("Silence of a periodic stream in seconds.", 0.01, 3600.0)));
  common.most_age = from_seconds(declare_parameter<double>(
      "max_age", 0.0, bounded("Age of a message in seconds that is a warning; 0 for any.", 0.0, 3600.0)));

  const auto refuse_value = [&](Problem problem) -> void {
    problem.where.node = get_fully_qualified_name();
    declare_problem(problem);  // a check of the launch file finds the line by its parameter
    throw exceptions::InvalidParameterValueException(problem.text());
  };
  if (share != "reference" && share != "pointer") {
    refuse_value({Place::of_parameter("share_as"), "'" + share + "' is not a form",
                  suggestion(share, {"reference", "pointer"})});
  }
  if (!rates.empty() && rates.size() != entries.size()) {
    refuse_value({Place::of_parameter("expected_rates"),
                  fmt::format("has {} values for {} streams", rates.size(), entries.size()),
                  "give one per stream, 0 where any rate is fine"});
  }
  const auto bad_rate =
      std::find_if(rates.begin(), rates.end(), [](double rate) { return !(rate >= 0 && rate <= 1e6); });
  if (bad_rate != rates.end())
    refuse_value({Place::of_parameter("expected_rates"), fmt::format("{} is not a rate", *bad_rate),
                  "give Hz from 0 to 1000000"});

  const ShareAs share_as = share == "pointer" ? ShareAs::Pointer : ShareAs::Reference;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    auto plan = plan_stream(entries[i]);
    if (!plan) refuse_value(plan.error());
    Stream& stream = streams_.emplace_back();
    stream.topic = resolve_topic_name(plan->topic);
    stream.expected = common;
    stream.expected.periodic = plan->periodic;
    stream.expected.rate_hz = rates.empty() ? 0.0 : rates[i];
    // A monitor announces no type on the network: the publishers, or the base that reads commands, do.
    const Announced announced = plan->types.size() > 1 ? Announced::WithItsPublisher : Announced::Always;
    for (const ReadableType* type : plan->types) {
      stream.type += (stream.type.empty() ? "" : " or ") + std::string(type->name);
      stream.subscriptions.push_back(type->subscribe(*this, plan->topic, plan->qos, share_as, announced, stream.watch));
    }
  }
}

CallbackReturn MonitorComponent::on_activate(const State&) {
  if (streams_.empty()) get_logger().warn("watches nothing: the parameter streams is empty");
  for (Stream& stream : streams_) stream.watch.start(steady_clock().now());
  return CallbackReturn::SUCCESS;
}

void MonitorComponent::report() {
  auto message = diagnostics_->borrow();
  if (!message) return;
  message->header.stamp = now();
  message->header.frame_id.clear();
  message->status.clear();
  const MonotonicTime time = steady_clock().now();
  for (Stream& stream : streams_) {
    const StreamReport seen = stream.watch.look(time, stream.expected);
    auto& status = message->status.emplace_back();
    status.level = static_cast<std::uint8_t>(seen.level);
    status.name = get_name() + ": " + stream.topic;
    status.message = seen.message;
    add(status, "type", stream.type);
    add(status, "rate_hz", fmt::format("{:.2f}", seen.rate_hz));
    if (stream.expected.rate_hz > 0) add(status, "expected_hz", fmt::format("{:.2f}", stream.expected.rate_hz));
    if (seen.oldest) add(status, "age_ms", fmt::format("{:.3f}", to_milliseconds(*seen.oldest)));
    if (seen.silent_for) add(status, "silent_ms", fmt::format("{:.1f}", to_milliseconds(*seen.silent_for)));
    add(status, "received", std::to_string(seen.received));
    add(status, "lost", std::to_string(seen.lost));
  }
  diagnostics_->publish(std::move(message));
}

}  // namespace nacelle::monitor
