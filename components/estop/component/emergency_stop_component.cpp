// SPDX-License-Identifier: Apache-2.0
#include "estop/component/emergency_stop_component.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "nacelle/io/backoff.hpp"

namespace nacelle::estop {
namespace {

const std::vector<std::string> kLevels{"high", "low"};
const std::vector<std::string> kBiases{"pull_up", "pull_down", "none"};
// Changes wake the thread. This only bounds how long a change that the kernel did not report can stay unseen.
constexpr Duration kLookPeriod = 500ms;
// The lifecycle gate opens just after on_activate(): a stop from before is published again until it gets through.
constexpr Duration kSayAgain = 5ms;

ParameterDescriptor described(std::string text) {
  ParameterDescriptor descriptor;
  descriptor.description = std::move(text);
  return descriptor;
}

// A base that requires this component (diff_drive's emergency_stop_required) detects its loss within this time.
constexpr Duration kLease = 500ms;
constexpr Duration kShowLife = 100ms;
// A thread that has not read its button for so long is considered stuck.
constexpr Duration kLookLimit = kLookPeriod + 500ms;

constexpr const char* kUnreadable = "the line of the emergency button cannot be read; the emergency stop is set";

QoS latched() { return QoS(KeepAll{}).reliable().transient_local(); }
QoS promised() { return latched().liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(kLease); }

}  // namespace

EmergencyStopComponent::EmergencyStopComponent(const NodeOptions& options, OpenSwitch open_switch)
    : LifecycleNode("estop", options), open_switch_(std::move(open_switch)) {
  declare_parameter("gpio_chip", "", described("e.g. /dev/gpiochip0; empty: there is no button"));
  declare_parameter("gpio_line", 0, described("the line's offset on the chip; on a Raspberry Pi the BCM number"));
  declare_parameter("gpio_stop_level", "high",
                    described("high (a contact to ground that opens when pressed, or when a wire breaks) or low"));
  declare_parameter("gpio_bias", "pull_up", described("pull_up, pull_down or none"));
  declare_device_parameters(*this);
  publisher_ = create_publisher<Bool>("emergency_stop", promised());
  button_publisher_ = create_publisher<Bool>("emergency_stop", promised());
  SubscriptionOptions releases;
  // Publishers that are not latched cannot release, and only releases count here.
  releases.event_callbacks.incompatible_qos_callback = [](const QOSRequestedIncompatibleQoSInfo&) {};
  heard_ = create_subscription<Bool>(
      "emergency_stop", latched(), [this](const Bool& stop) { on_heard(stop); }, releases);
  life_ = create_wall_timer(kShowLife, [this] { show_life(); });
  service_ = create_service<SetBool>(
      "~/set", [this](const SetBool::Request& request, SetBool::Response& response) { on_request(request, response); });
}

// From the executor, which also serves the service `~/set`; and only while the button's thread reads the button.
void EmergencyStopComponent::show_life() {
  if (has_button_ && steady_clock().now().nanoseconds() - looked_at_ns_ > kLookLimit.count()) return;
  publisher_->assert_liveliness();
  button_publisher_->assert_liveliness();
}

PublishResult EmergencyStopComponent::say(Publisher<Bool>& publisher, bool stop) {
  auto message = publisher.borrow();
  if (!message) return PublishResult::PoolDry;
  message->data = stop;
  return publisher.publish(std::move(message));
}

void EmergencyStopComponent::on_request(const SetBool::Request& request, SetBool::Response& response) {
  if (!request.data && pressed_) {
    response.success = false;
    response.message = "the button is pressed; unlock it, then release the stop";
    return;
  }
  response.success = say(*publisher_, request.data) == PublishResult::Published;
  response.message = !response.success ? "a reader of emergency_stop is full: is it hung?"
                     : request.data    ? "the emergency stop is set"
                                       : "the emergency stop is released";
}

void EmergencyStopComponent::on_heard(const Bool& stop) {
  if (stop.data || !pressed_) return;
  get_logger().warn("the emergency stop was released while the button is pressed: it is set again");
  static_cast<void>(say(*publisher_, true));
}

Result<GpioSettings, Problem> EmergencyStopComponent::gpio_settings() const {
  const auto problem_of = [this](const char* name, std::string what, std::string way_out) {
    return err(Problem{Place::of_parameter(name, get_fully_qualified_name()), std::move(what), std::move(way_out)});
  };
  GpioSettings settings;
  settings.chip = get<std::string>("gpio_chip");
  const auto line = get<std::int64_t>("gpio_line");
  if (line < 0 || line > 1023)
    return problem_of("gpio_line", fmt::format("{} is not in 0 to 1023", line), "`gpioinfo` lists them");
  settings.line = static_cast<unsigned>(line);
  const auto level = get<std::string>("gpio_stop_level");
  if (std::ranges::find(kLevels, level) == kLevels.end())
    return problem_of("gpio_stop_level", "'" + level + "' is not a level", suggestion(level, kLevels));
  settings.stops_when_high = level == "high";
  const auto bias = get<std::string>("gpio_bias");
  const auto found = std::ranges::find(kBiases, bias);
  if (found == kBiases.end()) return problem_of("gpio_bias", "'" + bias + "' is not a bias", suggestion(bias, kBiases));
  settings.bias = static_cast<Bias>(found - kBiases.begin());
  return settings;
}

CallbackReturn EmergencyStopComponent::on_configure(const State&) {
  const auto settings = gpio_settings();
  if (!settings) return refuse(settings.error());
  const auto device = read_device_parameters(*this);
  if (!device) return refuse(device.error());
  if (settings.value().chip.empty()) return CallbackReturn::SUCCESS;
  gpio_ = *settings;
  device_ = *device;
  auto opened = open_switch_(gpio_, steady_clock());
  std::error_code ignored;
  // Absent is not the same as unusable: rights, another program or a wrong line are not mended by waiting.
  const bool may_wait = !device_.required && !std::filesystem::exists(gpio_.chip, ignored);
  if (!opened && !may_wait) {
    Problem problem = opened.error();
    problem.where.node = get_fully_qualified_name();
    problem.where.parameter = "gpio_line";
    return refuse(problem);
  }
  watch_ = std::make_unique<DeviceWatch>(*this, device_, DeviceWatch::Settings{gpio_.chip}, steady_clock().now());
  if (opened) button_ = std::move(opened).value();
  has_button_ = true;
  return CallbackReturn::SUCCESS;
}

CallbackReturn EmergencyStopComponent::on_activate(const State&) {
  if (!has_button_) return CallbackReturn::SUCCESS;
  // Reported here, so that the bring-up can name the absent device. The thread sets the stop.
  if (!button_) watch_->lose(kUnreadable);
  ended_ = false;
  looked_at_ns_ = steady_clock().now().nanoseconds();
  thread_ = std::thread{[this] { watch(); }};
  return CallbackReturn::SUCCESS;
}

void EmergencyStopComponent::watch() noexcept {
  ::pthread_setname_np(::pthread_self(), "estop_button");
  bool told = true;
  io::Backoff backoff{50ms, kLookPeriod};  // it keeps reading the button, and asserting liveliness, meanwhile
  while (!ended_) {
    const auto pressed = button_ ? button_->is_pressed() : Result<bool, SwitchFault>{err(SwitchFault::Lost)};
    looked_at_ns_ = steady_clock().now().nanoseconds();
    // A button that cannot be read is pressed.
    const bool now_pressed = !pressed || pressed.value();
    if (now_pressed && !pressed_) told = false;
    pressed_ = now_pressed;
    if (!told) told = say(*button_publisher_, true) == PublishResult::Published;
    if (!pressed && told) {
      if (!bring_back(backoff.next())) return;
      continue;
    }
    if (pressed) {
      backoff.reset();
      watch_->heard(steady_clock().now());
    }
    if (!button_) {
      if (!pause(kSayAgain)) return;
      continue;
    }
    const auto changed = button_->wait_until(steady_clock().now() + (told ? kLookPeriod : kSayAgain));
    // A press between two reads counts. If the line was lost, the next read reports it again.
    if (changed && changed.value()) told = false;
  }
}

bool EmergencyStopComponent::pause(Duration length) {
  UniqueLock lock{mutex_};
  return !end_asked_.wait_for(lock.raw(), length, [this] { return ended_.load(); });
}

bool EmergencyStopComponent::bring_back(Duration length) {
  if (device_.lost == DeviceLost::Fault) {
    fault("GPIO_LOST", "the line of the emergency button cannot be read any more; the emergency stop is set");
    return false;
  }
  watch_->lose(kUnreadable);
  if (!pause(length)) return false;
  {
    // The old request holds the line, if the chip is still there.
    const LockGuard lock{mutex_};
    button_.reset();
  }
  auto opened = open_switch_(gpio_, steady_clock());
  const LockGuard lock{mutex_};
  if (opened) button_ = std::move(opened).value();
  return true;
}

void EmergencyStopComponent::end_watch() {
  if (!thread_.joinable()) return;
  {
    const LockGuard lock{mutex_};
    ended_ = true;
    if (button_) button_->interrupt();
  }
  end_asked_.notify_all();
  thread_.join();
}

CallbackReturn EmergencyStopComponent::on_deactivate(const State&) {
  end_watch();
  if (watch_) watch_->heard(steady_clock().now());  // the thread does not run until the next activation
  return CallbackReturn::SUCCESS;
}

CallbackReturn EmergencyStopComponent::on_cleanup(const State&) {
  end_watch();
  watch_.reset();
  button_.reset();
  has_button_ = false;
  return CallbackReturn::SUCCESS;
}

}  // namespace nacelle::estop
