// SPDX-License-Identifier: Apache-2.0
#include "joy/component/joy_component.hpp"

#include <fmt/format.h>

#include "joy/port/evdev_pad.hpp"

namespace nacelle::joy {
namespace {

Result<std::unique_ptr<PadPort>, Problem> open_evdev(const JoyOptions& options, const Clock& clock) {
  return options.device.required ? EvdevPad::open(options.wish, clock) : EvdevPad::open_or_await(options.wish, clock);
}

}  // namespace

JoyComponent::JoyComponent(const NodeOptions& options) : JoyComponent(options, open_evdev) {}

JoyComponent::JoyComponent(const NodeOptions& options, OpenPad open_pad)
    : LifecycleNode("joy_node", options), open_pad_(std::move(open_pad)) {
  declare_joy_parameters(*this);
  if (const auto read = read_joy_parameters(*this); !read) declare_problem(read.error());
  publisher_ = create_publisher<sensor_msgs::msg::Joy>("joy", QoS(10));
  add_gate_listener(*this);
}

JoyComponent::~JoyComponent() {
  remove_gate_listener(*this);
  close();
}

void JoyComponent::before_gate_closes() noexcept {
  if (stream_) stream_->set_active(false);
}

CallbackReturn JoyComponent::on_configure(const State&) {
  const auto options = read_joy_parameters(*this);
  if (!options) return refuse(options.error());
  auto pad = open_pad_(*options, steady_clock());
  if (!pad) return refuse(pad.error());
  pad_ = std::move(pad).value();
  // No silence is a loss: a gamepad that lies on the table sends nothing. Its absence is.
  watch_ = std::make_unique<DeviceWatch>(
      *this, options->device,
      DeviceWatch::Settings{options->title(), Duration::max() / 2, "JOY_ABSENT", options->silence_limit},
      steady_clock().now());
  stream_ = std::make_unique<JoyStream>(*options, steady_clock(), *pad_, publisher_, get_logger(), *watch_);
  if (pad_->is_away()) {
    watch_->lose(std::string(io::explain(io::StreamFault::NotFound)));
  } else {
    stream_->begin(steady_clock().now());
  }
  reader_ = std::make_unique<io::ReaderThread>(
      *pad_, steady_clock(), *stream_,
      io::ReaderThread::Options{.name = "joy_rx",
                                .on_exception = [this](const std::string& text) { fault("READER_ENDED", text); }});
  return CallbackReturn::SUCCESS;
}

CallbackReturn JoyComponent::on_activate(const State&) {
  stream_->set_active(true);
  return CallbackReturn::SUCCESS;
}

CallbackReturn JoyComponent::on_deactivate(const State&) {
  log_counters();
  return CallbackReturn::SUCCESS;
}

CallbackReturn JoyComponent::on_cleanup(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn JoyComponent::on_shutdown(const State&) {
  close();
  return CallbackReturn::SUCCESS;
}

CallbackReturn JoyComponent::on_error(const State&) {
  if (stream_) log_counters();
  close();
  return CallbackReturn::SUCCESS;
}

void JoyComponent::close() {
  reader_.reset();
  stream_.reset();
  watch_.reset();
  pad_.reset();
}

void JoyComponent::log_counters() const {
  const JoyCounters counters = stream_->counters();
  get_logger().info(
      "{} messages published ({} neutral); {} events in {} groups, {} overruns; the gamepad was lost {} times",
      counters.published, counters.neutral, counters.line.events, counters.groups, counters.overruns,
      reader_->stats().breaks);
}

}  // namespace nacelle::joy
