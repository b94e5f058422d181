// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_component.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "diff_drive/component/boards.hpp"
#include "diff_drive/component/hindrance.hpp"
#include "diff_drive/component/pwm_base.hpp"
#include "diff_drive/component/serial_base_port.hpp"
#include "diff_drive/port/loopback_port.hpp"
#include "nacelle/io/can_port.hpp"
#include "nacelle/io/serial_port.hpp"

namespace nacelle::diff_drive {
namespace {

// A person types, a planner plans: ten waiting commands are more than either sends in one control cycle.
constexpr std::size_t kCommandDepth = 10;
constexpr std::size_t kStateDepth = 10;
constexpr std::size_t kStopDepth = 100;
constexpr Duration kHindrancePeriod = 100ms;
constexpr Duration kBusTakesWithin = 5ms;

const char* explain(CommandFault fault) {
  switch (fault) {
    case CommandFault::NotFinite: return "it holds a NaN or an infinite number";
    case CommandFault::Absurd: return "it is faster than any base on wheels";
    case CommandFault::Stale:
      return "its stamp is older than the timeout of its topic; are the sender's and this machine's clocks set?";
    case CommandFault::Inactive:
      return "diff_drive_controller is not active; `ros2 control switch_controllers` activates it";
  }
  return "";
}

RawTwist raw(const geometry_msgs::msg::Twist& t) {
  return {t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z};
}

std::string advice(DriveFault::Kind kind) {
  switch (kind) {
    case DriveFault::Kind::SerialLost: return "plug the board in again, then configure and activate this node";
    case DriveFault::Kind::SerialStuck: return "is the board on, and is its line the right one?";
    case DriveFault::Kind::FeedbackLost:
      return "is its baud or bit rate right, and is it the board that hardware names?";
  }
  return {};
}

}  // namespace

DiffDriveComponent::DiffDriveComponent(const NodeOptions& options)
    : LifecycleNode("diff_drive", options),
      described_(read_described_base(*this)),
      options_((declare_options(*this, described_.defaults), read_options(*this))),
      command_to_wheel_(create_histogram("command_to_wheel")),
      motion_stops_(shared_object<MotionStops>(kMotionStopsName, &make_motion_stops)),
      wheels_(shared_object<BaseWheelsList>(kBaseWheelsName, &make_base_wheels)),
      inbox_(options_.inputs.size(), options_.locks.size()) {
  inbox_.stops_from_outside = &motion_stops_->count;
  for (const auto& problem : described_.problems) declare_problem(problem);
  for (const auto& warning : described_.warnings) declare_warning(warning);
  if (const auto setup = validated(options_, get_fully_qualified_name()); setup) {
    tell_wheels();
  } else {
    declare_problem(setup.error());
  }
  // Several programs may use a CAN interface.
  if (const BoardKind* const kind = board_kind(options_.hardware); kind != nullptr && !kind->is_on_can && !kind->is_pwm)
    declare_device_use(options_.serial_port, "serial_port");
  publishers_.joint_states = create_publisher<sensor_msgs::msg::JointState>("joint_states", QoS(kStateDepth));
  publishers_.battery = create_publisher<sensor_msgs::msg::BatteryState>("battery/state", QoS(kStateDepth));
  if (get<bool>("publish_limited_velocity")) {
    limited_velocity_ = create_publisher<geometry_msgs::msg::TwistStamped>("~/cmd_vel_out", QoS(kStateDepth));
  }
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", QoS(kStateDepth));
  // The first subscription: if activation delivers latched messages, a stop precedes any command.
  listen_for_emergency_stop();
  listen_for_guards();
  for (std::size_t i = 0; i < options_.locks.size(); ++i) listen_to_lock(i, options_.locks[i].topic);
  for (std::size_t i = 0; i < options_.inputs.size(); ++i) listen_to(i, options_.inputs[i].topic);
  hindrance_timer_ = create_wall_timer(kHindrancePeriod, [this] { tell_hindrance(); });
  if (get<bool>("controller_manager"))
    controllers_ = std::make_unique<ControllerServices>(options, *this, inbox_, description());
}

ControllerServices::Description DiffDriveComponent::description() const {
  return {options_.left_wheel_names, options_.right_wheel_names, options_.update_rate_hz, options_.hardware};
}

void DiffDriveComponent::tell_wheels() {
  auto list = wheels_->lock();
  std::erase_if(*list, [this](const BaseWheels& base) { return base.node == get_fully_qualified_name(); });
  list->push_back({get_fully_qualified_name(), get_namespace(), options_.left_wheel_names, options_.right_wheel_names,
                   options_.wheel_separation_m, options_.wheel_radius_m, options_.wheel_separation_multiplier,
                   options_.left_wheel_radius_multiplier, options_.right_wheel_radius_multiplier});
}

void DiffDriveComponent::listen_to(std::size_t source, const std::string& topic) {
  if (topic.empty()) return;  // configure says so
  using geometry_msgs::msg::Twist;
  using geometry_msgs::msg::TwistStamped;
  const QoS qos = QoS(kCommandDepth).reliable();
  const InputOptions& input = options_.inputs[source];
  SubscriptionOptions said;
  said.command_timeout = {from_seconds(input.timeout_s), input.timeout_parameter()};
  const auto announced = [](bool by_default) {
    return by_default ? Announced::ByDefault : Announced::WithItsPublisher;
  };
  said.announced = announced(!options_.use_stamped_vel);
  listeners_.push_back(create_subscription<Twist>(
      topic, qos, [this, source](const Twist& twist, const MessageInfo& info) { on_twist(source, twist, info); },
      said));
  said.announced = announced(options_.use_stamped_vel);
  listeners_.push_back(create_subscription<TwistStamped>(
      topic, qos,
      [this, source](const TwistStamped& command, const MessageInfo& info) { on_twist_stamped(source, command, info); },
      said));
}

void DiffDriveComponent::listen_to_lock(std::size_t lock, const std::string& topic) {
  if (topic.empty()) return;
  listeners_.push_back(create_subscription<std_msgs::msg::Bool>(
      topic, QoS(kCommandDepth).reliable(), [this, lock](const std_msgs::msg::Bool& locked, const MessageInfo& info) {
        inbox_.locks[lock].locked.store(locked.data);
        inbox_.locks[lock].heard_at_ns.store(info.received_time.nanoseconds());
      }));
}

DiffDriveComponent::~DiffDriveComponent() {
  stop_base();
  close_base();
  std::erase_if(*wheels_->lock(), [this](const BaseWheels& base) { return base.node == get_fully_qualified_name(); });
}

void DiffDriveComponent::on_twist(std::size_t source, const geometry_msgs::msg::Twist& twist, const MessageInfo& info) {
  const auto wanted = accepted(raw(twist));
  if (!wanted) return refuse_command(source, wanted.error(), info);
  // The loop reads what is at rest, also while it holds the wheels: only motion is refused.
  if (inbox_.inactive.is_set.load(std::memory_order_acquire) && wanted.value() != BodyTwist{})
    return refuse_command(source, CommandFault::Inactive, info);
  refusal_told_ = {};
  ++command_stats_.accepted;
  inbox_.sources[source].commands.put({wanted.value(), info.received_time, info.source_time, info.sequence == 1});
}

void DiffDriveComponent::on_twist_stamped(std::size_t source, const geometry_msgs::msg::TwistStamped& command,
                                          const MessageInfo& info) {
  if (is_stale(source, command.header.stamp)) return refuse_command(source, CommandFault::Stale, info);
  on_twist(source, command.twist, info);
}

void DiffDriveComponent::on_emergency_stop(const std_msgs::msg::Bool& stop, const MessageInfo& info) {
  const bool is_set = emergency_.take(stop.data, info.source_time);
  if (!is_set) return inbox_.emergency_stop.release(steady_clock().now());
  inbox_.emergency_stop.set();
  if (loop_) loop_->interrupt();
}

// A stop must take effect with any QoS of its publisher (`ros2 topic pub` is volatile). Therefore a second subscription requests
// nothing, and also matches publishers that are incompatible with the first one. It only sets the stop: a releasing publisher must
// reach late joiners, too.
void DiffDriveComponent::listen_for_emergency_stop() {
  const QoS latched = QoS(KeepAll{}).reliable().transient_local();
  SubscriptionOptions first;
  first.event_callbacks.incompatible_qos_callback = [](const QOSRequestedIncompatibleQoSInfo&) {};  // the second's
  listeners_.push_back(create_subscription<std_msgs::msg::Bool>(
      "emergency_stop", latched,
      [this](const std_msgs::msg::Bool& stop, const MessageInfo& info) { on_emergency_stop(stop, info); }, first));
  SubscriptionOptions second;
  second.unless_offered = latched;
  listeners_.push_back(create_subscription<std_msgs::msg::Bool>(
      "emergency_stop", QoS(kStopDepth).best_effort(),
      [this](const std_msgs::msg::Bool& stop, const MessageInfo& info) {
        if (stop.data) return on_emergency_stop(stop, info);
        get_logger().warn(
            "a release of the emergency stop is not obeyed: its publisher is not reliable and transient_local; "
            "`nacelle estop release` releases it, or `ros2 topic pub --qos-durability transient_local`");
      },
      second));
}

// Distinguishes publishers that assert liveliness from those that only publish (`nacelle estop`, `topic pub`).
void DiffDriveComponent::listen_for_guards() {
  if (!options_.emergency_stop_required) return;
  inbox_.unguarded.set();
  SubscriptionOptions events;
  events.event_callbacks.liveliness_callback = [this](const QOSLivelinessChangedInfo& now_is) {
    if (now_is.alive_count != 0) return inbox_.unguarded.release(steady_clock().now());
    inbox_.unguarded.set();
    if (loop_) loop_->interrupt();
  };
  // Those that promise nothing are the other subscriptions', and so are the messages of all.
  events.event_callbacks.incompatible_qos_callback = [](const QOSRequestedIncompatibleQoSInfo&) {};
  const QoS promised = QoS(KeepAll{})
                           .reliable()
                           .transient_local()
                           .liveliness(Liveliness::ManualByTopic)
                           .liveliness_lease_duration(from_seconds(options_.emergency_stop_timeout_s));
  listeners_.push_back(create_subscription<std_msgs::msg::Bool>(
      "emergency_stop", promised, [](const std_msgs::msg::Bool&) {}, events));
}

bool DiffDriveComponent::is_stale(std::size_t source, const builtin_interfaces::msg::Time& stamp) const {
  // A stamp of zero means "now", as in diff_drive_controller; one from the future is a matter of clocks and not of age.
  const Duration timeout = setup_.loop.input.sources[source].timeout;
  if (timeout == Duration::zero() || (stamp.sec == 0 && stamp.nanosec == 0)) return false;
  const WallTime sent{std::chrono::seconds{stamp.sec} + Duration{stamp.nanosec}};
  return now() - sent > timeout;
}

void DiffDriveComponent::refuse_command(std::size_t source, CommandFault fault, const MessageInfo& info) {
  inbox_.sources[source].refused_at_ns.store(info.received_time.nanoseconds());
  const auto index = static_cast<std::size_t>(fault);
  ++command_stats_.refused[index];
  // Once per bad spell: a broken sender repeats itself many times a second.
  if (std::exchange(refusal_told_[index], true)) return;
  const char* const until_then =
      fault == CommandFault::Inactive ? "" : "; the one before it stays in force until its timeout";
  get_logger().warn("a command on {} is refused: {}{}", options_.inputs[source].topic, explain(fault), until_then);
}

void DiffDriveComponent::tell_hindrance() {
  if (!loop_) return;
  const Hindrance now_is = hindrance_of(loop_->look(), loop_->board_fault());
  const bool changed = now_is.text != hindrance_;
  if (changed) {
    hindrance_ = now_is.text;
    ticks_until_told_ = 0;
    if (hindrance_.empty()) {
      get_logger().info("the base follows its commands again");
    } else {
      get_logger().warn("the base stands still: {}", hindrance_);
    }
  }
  // An undisturbed base says nothing, and so allocates nothing.
  if (!changed && (hindrance_.empty() || --ticks_until_told_ > 0)) return;
  ticks_until_told_ = static_cast<int>(1s / kHindrancePeriod);
  auto message = diagnostics_->borrow();
  if (!message) return;
  message->header.stamp = now();
  message->status.resize(1);
  auto& status = message->status[0];
  status.level = now_is.level;
  status.name = get_name() + ": motion";
  status.message = hindrance_.empty() ? "follows its commands" : hindrance_;
  status.hardware_id = line_of_board(options_);
  status.values.clear();
  diagnostics_->publish(std::move(message));
}

Result<std::unique_ptr<BasePort>, Problem> DiffDriveComponent::open_base() const {
  if (options_.hardware == "loopback")
    return std::unique_ptr<BasePort>{std::make_unique<LoopbackPort>(steady_clock(), LoopbackPort::Settings{})};
  if (board_kind(options_.hardware)->is_on_can) return open_bus();
  if (board_kind(options_.hardware)->is_pwm) return open_pins();

  io::SerialSettings line_settings;
  line_settings.path = options_.serial_port;
  line_settings.baud =
      options_.baud_rate == 0 ? board_kind(options_.hardware)->usual_baud : static_cast<unsigned>(options_.baud_rate);
  // A command that does not get through within half a cycle must not delay the next cycle.
  line_settings.write_timeout = setup_.loop.period / 2;
  auto line = options_.device.required ? io::SerialPort::open(line_settings, steady_clock(), setup_.loop.silence_limit)
                                       : io::SerialPort::open_or_await(line_settings, steady_clock());
  if (!line) {
    Problem problem = line.error();
    problem.where.node = get_fully_qualified_name();
    problem.where.parameter = "serial_port";
    return err(std::move(problem));
  }
  SerialBasePort::Settings settings;
  settings.byte_time = io::byte_time(line_settings.baud);
  settings.max_wheel_rate_rps = options_.max_wheel_rate_rps;
  settings.expected = io::ExpectedDevice{
      .path = options_.serial_port,
      .name = options_.hardware,
      .usual_baud = board_kind(options_.hardware)->usual_baud,
      .baud = line_settings.baud,
      .baud_parameter = "baud_rate",
      .when_silent =
          fmt::format("is the motor board powered, is this its line, and is its baud rate {}?", line_settings.baud)};
  return std::unique_ptr<BasePort>{
      std::make_unique<SerialBasePort>(std::move(line).value(), make_board(options_), steady_clock(), settings)};
}

Result<std::unique_ptr<BasePort>, Problem> DiffDriveComponent::open_pins() const {
  auto base = open_pwm_base(options_, wiring_of_board(options_), steady_clock());
  if (base) return base;
  Problem problem = base.error();
  problem.where.node = get_fully_qualified_name();
  return err(std::move(problem));
}

Result<std::unique_ptr<BasePort>, Problem> DiffDriveComponent::open_bus() const {
  io::CanSettings bus_settings;
  bus_settings.interface = options_.can_interface;
  bus_settings.filters = filters_of_board(options_);
  // As of a serial line; a start writes more frames than a bus of 250 kbit/s carries in half a fast cycle.
  bus_settings.write_timeout = std::max(setup_.loop.period / 2, kBusTakesWithin);
  auto bus = options_.device.required ? io::CanPort::open(bus_settings, steady_clock(), setup_.loop.silence_limit)
                                      : io::CanPort::open_or_await(bus_settings, steady_clock());
  if (!bus) {
    Problem problem = bus.error();
    problem.where.node = get_fully_qualified_name();
    problem.where.parameter = "can_interface";
    return err(std::move(problem));
  }
  SerialBasePort::Settings settings;
  settings.max_wheel_rate_rps = options_.max_wheel_rate_rps;
  return std::unique_ptr<BasePort>{
      std::make_unique<SerialBasePort>(std::move(bus).value(), make_board(options_), steady_clock(), settings)};
}

CallbackReturn DiffDriveComponent::on_configure(const State&) {
  if (!described_.problems.empty()) return refuse(described_.problems.front());
  for (const auto& warning : described_.warnings) get_logger().warn("{}", warning.text());
  auto options = read_options(*this);
  // The subscriptions are those of the constructor.
  for (std::size_t i = 0; i < options.inputs.size(); ++i) options.inputs[i].topic = options_.inputs[i].topic;
  for (std::size_t i = 0; i < options.locks.size(); ++i) options.locks[i].topic = options_.locks[i].topic;
  const auto device = read_device_parameters(*this);
  if (!device) return refuse(device.error());
  options.device = *device;
  options_ = std::move(options);
  auto setup = validated(options_, get_fully_qualified_name());
  if (!setup) return refuse(setup.error());
  setup_ = std::move(setup).value();
  tell_wheels();
  for (const auto& warning : setup_.warnings) get_logger().warn("{}", warning);

  auto base = open_base();
  if (!base) return refuse(base.error());
  base_ = std::move(base).value();
  if (base_->descriptor() >= 0) register_safe_stop(base_->descriptor(), base_->stop_frame());
  for (const int further : base_->further_descriptors()) register_safe_stop(further, base_->stop_frame());

  publishers_.limited_velocity = limited_velocity_;
  topics_ = std::make_unique<DriveTopics>(publishers_,
                                          DriveTopics::Settings{options_.left_wheel_names, options_.right_wheel_names,
                                                                setup_.publish_period, setup_.battery_period},
                                          steady_clock(), command_to_wheel_);
  watch_ = std::make_unique<DeviceWatch>(*this, options_.device, DeviceWatch::Settings{line_of_board(options_)},
                                         steady_clock().now());
  topics_->watch_with(watch_.get());
  topics_->be_quiet_while(&inbox_.without_joint_states);
  if (controllers_) controllers_->describe(description());
  loop_ = std::make_unique<DriveLoop>(setup_.loop, *base_, steady_clock(), inbox_, *topics_);
  return CallbackReturn::SUCCESS;
}

CallbackReturn DiffDriveComponent::on_activate(const State&) {
  const auto started = base_->start();
  const bool is_waited_for = !options_.device.required && setup_.loop.waits_for_board;
  if (!started && !is_waited_for) {
    return refuse(Problem{get_fully_qualified_name(), std::string(nacelle::diff_drive::explain(started.error())),
                          "check the cable, then configure and activate this node again"});
  }
  // What was sent before this instant belongs to another drive.
  loop_->arm(steady_clock().now());
  if (!started) {
    watch_->lose(std::string(nacelle::diff_drive::explain(started.error())));
    loop_->begin_without_board();
  }
  if (controllers_) controllers_->follow(loop_.get());
  loop_thread_ = std::thread{[this] { run_loop(); }};
  return CallbackReturn::SUCCESS;
}

void DiffDriveComponent::run_loop() noexcept {
  ::pthread_setname_np(::pthread_self(), "diff_drive_loop");
  try {
    const auto ended = loop_->run();
    if (ended) return;
    const DriveFault& why = ended.error();
    std::string cause{nacelle::diff_drive::explain(why.base)};
    if (why.kind == DriveFault::Kind::FeedbackLost) {
      cause = base_->why_no_state(setup_.loop.silence_limit);
      if (cause.empty())
        cause = fmt::format("the motor board said nothing for {} s", to_seconds(setup_.loop.silence_limit));
    }
    const auto stats = base_->stats();
    fault(code_of(why.kind), fmt::format("{}; {} ({} commands written, {} cycles not, {} states heard)", cause,
                                         advice(why.kind), stats.commands, loop_->stats().unwritten, stats.states));
  } catch (const std::exception& e) {
    static_cast<void>(base_->stop());
    fault("LOOP_THREW", e.what());
  } catch (...) {
    static_cast<void>(base_->stop());
    fault("LOOP_THREW", "an exception other than a std::exception");
  }
}

void DiffDriveComponent::stop_base() {
  if (controllers_) controllers_->follow(nullptr);
  if (loop_thread_.joinable()) {
    loop_->stop();
    loop_thread_.join();
    const auto base = base_->stats();
    const auto& loop = loop_->stats();
    get_logger().info(
        "{} cycles ({} skipped, {} not written), {} states of the wheels, {} of {} bytes lost, {} command timeouts, "
        "the board was lost {} times",
        loop.cycles, loop.skipped, loop.unwritten, base.states, base.bytes_lost, base.bytes_in, loop.commands.timeouts,
        loop.lost);
    if (base.edges_lost > 0)
      get_logger().warn("{} edges of the encoders were lost, {} were seen", base.edges_lost, base.edges);
  }
  // A lost line takes no command; the board's own watchdog stops the wheels then.
  if (base_) static_cast<void>(base_->stop());
}

void DiffDriveComponent::close_base() {
  if (base_ && base_->descriptor() >= 0) clear_safe_stop();
  loop_.reset();
  topics_.reset();
  watch_.reset();
  base_.reset();
}

CallbackReturn DiffDriveComponent::on_deactivate(const State&) {
  stop_base();
  watch_->heard(steady_clock().now());  // the loop does not run until the next activation
  return CallbackReturn::SUCCESS;
}

CallbackReturn DiffDriveComponent::on_cleanup(const State&) {
  stop_base();
  close_base();
  return CallbackReturn::SUCCESS;
}

CallbackReturn DiffDriveComponent::on_shutdown(const State& state) { return on_cleanup(state); }

CallbackReturn DiffDriveComponent::on_error(const State& state) { return on_cleanup(state); }

}  // namespace nacelle::diff_drive
