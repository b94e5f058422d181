// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_component.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <exception>
#include <utility>

#include "diff_drive/component/waveshare_serial_port.hpp"
#include "diff_drive/port/loopback_port.hpp"
#include "nacelle/io/serial_port.hpp"

namespace nacelle::diff_drive {
namespace {

// A person types, a planner plans: ten waiting commands are more than either sends in one control cycle.
constexpr std::size_t kCommandDepth = 10;
constexpr std::size_t kStateDepth = 10;

const char* explain(CommandFault fault) {
  switch (fault) {
    case CommandFault::NotFinite: return "it holds a NaN or an infinite number";
    case CommandFault::Absurd: return "it is faster than any base on wheels";
    case CommandFault::Stale:
      return "its stamp is older than cmd_vel_timeout; are the sender's and this machine's clocks set?";
  }
  return "";
}

RawTwist raw(const geometry_msgs::msg::Twist& t) {
  return {t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z};
}

std::string advice(DriveFault::Kind kind) {
  switch (kind) {
    case DriveFault::Kind::SerialLost: return "plug the board in again, then configure and activate this node";
    case DriveFault::Kind::SerialStuck: return "is the board on? is serial_port the right line?";
    case DriveFault::Kind::FeedbackLost: return "no T 1001 line came; is baud_rate right, is it a Waveshare UGV board?";
  }
  return {};
}

}  // namespace

DiffDriveComponent::DiffDriveComponent(const NodeOptions& options)
    : LifecycleNode("diff_drive", options), command_to_wheel_(create_histogram("command_to_wheel")) {
  declare_options(*this);
  if (const auto setup = validated(read_options(*this), get_fully_qualified_name()); !setup)
    declare_problem(setup.error());
  publishers_.joint_states = create_publisher<sensor_msgs::msg::JointState>("joint_states", QoS(kStateDepth));
  publishers_.battery = create_publisher<sensor_msgs::msg::BatteryState>("battery/state", QoS(kStateDepth));
  if (get<bool>("publish_limited_velocity")) {
    limited_velocity_ = create_publisher<geometry_msgs::msg::TwistStamped>("~/cmd_vel_out", QoS(kStateDepth));
  }
  twists_ = create_subscription<geometry_msgs::msg::Twist>(
      "cmd_vel", QoS(kCommandDepth).reliable(),
      [this](const geometry_msgs::msg::Twist& twist, const MessageInfo& info) { on_twist(twist, info); });
  stamped_twists_ = create_subscription<geometry_msgs::msg::TwistStamped>(
      "cmd_vel", QoS(kCommandDepth).reliable(),
      [this](const geometry_msgs::msg::TwistStamped& command, const MessageInfo& info) {
        on_twist_stamped(command, info);
      });
}

DiffDriveComponent::~DiffDriveComponent() {
  stop_base();
  close_base();
}

void DiffDriveComponent::on_twist(const geometry_msgs::msg::Twist& twist, const MessageInfo& info) {
  const auto wanted = accepted(raw(twist));
  if (!wanted) return refuse_command(wanted.error());
  refusal_told_ = {};
  ++command_stats_.accepted;
  commands_.put({wanted.value(), info.received_time, info.source_time});
}

void DiffDriveComponent::on_twist_stamped(const geometry_msgs::msg::TwistStamped& command, const MessageInfo& info) {
  if (is_stale(command.header.stamp)) return refuse_command(CommandFault::Stale);
  on_twist(command.twist, info);
}

bool DiffDriveComponent::is_stale(const builtin_interfaces::msg::Time& stamp) const {
  // A stamp of zero means "now", as in diff_drive_controller; one from the future is a matter of clocks and not of age.
  if (setup_.loop.command_timeout == Duration::zero() || (stamp.sec == 0 && stamp.nanosec == 0)) return false;
  const WallTime sent{std::chrono::seconds{stamp.sec} + Duration{stamp.nanosec}};
  return now() - sent > setup_.loop.command_timeout;
}

void DiffDriveComponent::refuse_command(CommandFault fault) {
  const auto index = static_cast<std::size_t>(fault);
  ++command_stats_.refused[index];
  // Once per bad spell: a broken sender repeats itself many times a second.
  if (std::exchange(refusal_told_[index], true)) return;
  get_logger().warn("a command on cmd_vel is refused: {}; the one before it stays in force until its timeout",
                    explain(fault));
}

Result<std::unique_ptr<BasePort>, Problem> DiffDriveComponent::open_base() const {
  if (options_.hardware == "loopback")
    return std::unique_ptr<BasePort>{std::make_unique<LoopbackPort>(get_clock(), LoopbackPort::Settings{})};

  io::SerialSettings line_settings;
  line_settings.path = options_.serial_port;
  line_settings.baud = static_cast<unsigned>(options_.baud_rate);
  // A command that does not get through within half a cycle must not delay the next cycle.
  line_settings.write_timeout = setup_.loop.period / 2;
  auto line = io::SerialPort::open(line_settings, get_clock(), setup_.loop.silence_limit);
  if (!line) {
    Problem problem = line.error();
    problem.where = get_fully_qualified_name() + ", parameter serial_port: " + problem.where;
    return err(std::move(problem));
  }
  WaveshareSerialPort::Settings settings;
  settings.wheel_radius_m = options_.wheel_radius_m;
  settings.motor_watchdog =
      std::chrono::duration_cast<std::chrono::milliseconds>(from_seconds(options_.motor_watchdog_s));
  settings.byte_time = io::byte_time(line_settings.baud);
  return std::unique_ptr<BasePort>{
      std::make_unique<WaveshareSerialPort>(std::move(line).value(), get_clock(), settings)};
}

CallbackReturn DiffDriveComponent::on_configure(const State&) {
  options_ = read_options(*this);
  auto setup = validated(options_, get_fully_qualified_name());
  if (!setup) return refuse(setup.error());
  setup_ = std::move(setup).value();
  for (const auto& warning : setup_.warnings) get_logger().warn("{}", warning);

  auto base = open_base();
  if (!base) return refuse(base.error());
  base_ = std::move(base).value();
  if (base_->descriptor() >= 0) register_safe_stop(base_->descriptor(), base_->stop_frame());

  publishers_.limited_velocity = limited_velocity_;
  topics_ = std::make_unique<DriveTopics>(publishers_,
                                          DriveTopics::Settings{options_.left_wheel_names, options_.right_wheel_names,
                                                                setup_.publish_period, setup_.battery_period},
                                          get_clock(), command_to_wheel_);
  loop_ = std::make_unique<DriveLoop>(setup_.loop, *base_, get_clock(), commands_, *topics_);
  return CallbackReturn::SUCCESS;
}

CallbackReturn DiffDriveComponent::on_activate(const State&) {
  if (const auto started = base_->start(); !started) {
    return refuse(Problem{get_fully_qualified_name(), std::string(nacelle::diff_drive::explain(started.error())),
                          "check the cable, then configure and activate this node again"});
  }
  // What was sent before this instant belongs to another drive.
  loop_->arm(get_clock().now());
  loop_thread_ = std::thread{[this] { run_loop(); }};
  return CallbackReturn::SUCCESS;
}

void DiffDriveComponent::run_loop() noexcept {
  ::pthread_setname_np(::pthread_self(), "diff_drive_loop");
  try {
    const auto ended = loop_->run();
    if (ended) return;
    const DriveFault& why = ended.error();
    const std::string cause =
        why.kind == DriveFault::Kind::FeedbackLost
            ? fmt::format("the motor board said nothing for {} s", to_seconds(setup_.loop.silence_limit))
            : std::string(nacelle::diff_drive::explain(why.base));
    const auto stats = base_->stats();
    fault(code_of(why.kind), fmt::format("{}; {} ({} commands written, {} cycles not, {} states heard)", cause,
                                         advice(why.kind), stats.commands, loop_->stats().unwritten, stats.states));
  } catch (const std::exception& e) {
    static_cast<void>(base_->stop());
    fault("LOOP_THREW", e.what());
  } catch (...) {
    static_cast<void>(base_->stop());
    fault("LOOP_THREW", "an exception that is no std::exception");
  }
}

void DiffDriveComponent::stop_base() {
  if (loop_thread_.joinable()) {
    loop_->stop();
    loop_thread_.join();
    const auto base = base_->stats();
    const auto& loop = loop_->stats();
    get_logger().info(
        "{} cycles ({} skipped, {} not written), {} states of the wheels, {} of {} bytes lost, {} command timeouts",
        loop.cycles, loop.skipped, loop.unwritten, base.states, base.bytes_lost, base.bytes_in, loop.commands.timeouts);
  }
  // A lost line cannot be told; the board's own watchdog stops the wheels then.
  if (base_) static_cast<void>(base_->stop());
}

void DiffDriveComponent::close_base() {
  if (base_ && base_->descriptor() >= 0) clear_safe_stop();
  loop_.reset();
  topics_.reset();
  base_.reset();
}

CallbackReturn DiffDriveComponent::on_deactivate(const State&) {
  stop_base();
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
