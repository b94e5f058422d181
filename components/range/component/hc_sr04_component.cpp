// SPDX-License-Identifier: Apache-2.0
#include "range/component/hc_sr04_component.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "nacelle/node/frame_name.hpp"
#include "range/component/descriptors.hpp"

namespace nacelle::range {
namespace {

ParameterDescriptor line_descriptor(std::string text) {
  return {.description = std::move(text), .integer_range = IntegerRange{0, 1023}};
}

}  // namespace

HcSr04Component::HcSr04Component(const NodeOptions& options, RangeLoop::OpenLines open_lines)
    : LifecycleNode("range", options), open_lines_(std::move(open_lines)) {
  const RangeOptions defaults;
  declare_parameter("gpio_chip", defaults.lines.chip, described("e.g. /dev/gpiochip0"));
  declare_parameter("trigger_line", static_cast<int>(defaults.lines.trigger_line),
                    line_descriptor("offset of the line to TRIG; on a Raspberry Pi the BCM number"));
  declare_parameter("echo_line", static_cast<int>(defaults.lines.echo_line),
                    line_descriptor("offset of the line to ECHO, through a divider from 5 V to 3.3 V"));
  declare_frame_prefix(*this);
  declare_parameter("frame_id", defaults.frame_id, described("frame of the sensor: x where it looks"));
  declare_parameter("rate", defaults.rate_hz, within("Hz; above 16 the sensor may hear its echo before", 0.1, 20.0));
  declare_parameter("min_range", defaults.least_m, within("m; nearer is -Inf", 0.0, 6.0));
  declare_parameter("max_range", defaults.most_m, within("m; farther is +Inf", 0.0, 6.0));
  declare_parameter("field_of_view", defaults.field_of_view_rad, within("rad, of the cone", 0.0, 3.2));
  declare_parameter("temperature", defaults.temperature_c,
                    within("deg C of the air: the speed of sound, 0.18 % a degree", -50.0, 80.0));
  declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                    within("s without an answer that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(*this);
  declare_frame_use(frame_name(*this, "frame_id"), "frame_id");
  if (const auto read = read_options(); !read) declare_problem(read.error());
  publisher_ = create_publisher<sensor_msgs::msg::Range>("range", QoS(10).best_effort());
}

HcSr04Component::~HcSr04Component() { loop_.reset(); }

Result<RangeOptions, Problem> HcSr04Component::read_options() const {
  RangeOptions options;
  const auto refusal = [this](const char* name, std::string what, std::string way_out) {
    return err(Problem{Place::of_parameter(name, get_fully_qualified_name()), std::move(what), std::move(way_out)});
  };
  options.lines.chip = get<std::string>("gpio_chip");
  options.lines.trigger_line = static_cast<unsigned>(get<std::int64_t>("trigger_line"));
  options.lines.echo_line = static_cast<unsigned>(get<std::int64_t>("echo_line"));
  if (options.lines.trigger_line == options.lines.echo_line)
    return refusal("echo_line", fmt::format("{} is trigger_line, too", options.lines.echo_line), "they are two lines");
  options.frame_id = frame_name(*this, "frame_id");
  options.rate_hz = get<double>("rate");
  options.least_m = get<double>("min_range");
  options.most_m = get<double>("max_range");
  if (options.least_m >= options.most_m)
    return refusal("min_range", fmt::format("{} m is not below max_range {} m", options.least_m, options.most_m),
                   "an HC-SR04 measures from 0.02 to 4");
  options.field_of_view_rad = get<double>("field_of_view");
  options.temperature_c = get<double>("temperature");
  options.silence_limit = from_seconds(get<double>("silence_limit"));
  auto device = read_device_parameters(*this);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

CallbackReturn HcSr04Component::on_configure(const State&) {
  const auto options = read_options();
  if (!options) return refuse(options.error());
  options_ = *options;
  auto opened = open_lines_(options_.lines, steady_clock());
  std::error_code ignored;
  // Absent is not the same as unusable: rights, another program or a wrong line are not mended by waiting.
  const bool may_wait = !options_.device.required && !std::filesystem::exists(options_.lines.chip, ignored);
  if (!opened && !may_wait) return refuse(opened.error());
  if (opened) lines_ = std::move(opened).value();
  return CallbackReturn::SUCCESS;
}

CallbackReturn HcSr04Component::on_activate(const State&) {
  const Duration period = from_seconds(1.0 / options_.rate_hz);
  watch_ = std::make_unique<DeviceWatch>(
      *this, options_.device,
      DeviceWatch::Settings{fmt::format("HC-SR04 at lines {} and {} of {}", options_.lines.trigger_line,
                                        options_.lines.echo_line, options_.lines.chip),
                            silence_of(period), "RANGE_SILENT", options_.silence_limit},
      steady_clock().now());
  if (!lines_) watch_->lose("no such chip");  // reported here, so that the bring-up can name it
  loop_ = std::make_unique<RangeLoop>(options_, steady_clock(), open_lines_, lines_, publisher_, *watch_,
                                      [this](const std::string& text) { fault("RANGE_ENDED", text); });
  return CallbackReturn::SUCCESS;
}

CallbackReturn HcSr04Component::on_deactivate(const State&) {
  const RangeCounters counters = loop_->counters();
  loop_.reset();
  watch_.reset();
  get_logger().info("{} measurements, {} without an answer; {} published", counters.measured, counters.unanswered,
                    counters.published);
  return CallbackReturn::SUCCESS;
}

CallbackReturn HcSr04Component::on_cleanup(const State&) {
  loop_.reset();
  watch_.reset();
  lines_.reset();
  return CallbackReturn::SUCCESS;
}

}  // namespace nacelle::range
