// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "nacelle/base/log.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/host/node_host.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/node/node_options.hpp"
#include "nacelle/node/parameter.hpp"
#include "nacelle/node/publisher.hpp"
#include "nacelle/node/service.hpp"
#include "nacelle/node/subscription.hpp"
#include "nacelle/node/timer.hpp"
#include "nacelle/node/wake_up.hpp"

namespace nacelle {

/// A frame that a node's data is in, and the parameter that names it.
struct FrameUse {
  std::string frame, parameter;
};
/// A device that a node opens for itself alone, and the parameter that names it.
struct DeviceUse {
  std::string path, parameter;
};

/// The clock of stamps: the wall clock, or /clock for a node with use_sim_time. Threads: any.
class RosClock {
 public:
  explicit RosClock(const NodeHost& host) : host_(host) {}
  [[nodiscard]] WallTime now() const { return host_.clock().wall_now(); }

 private:
  const NodeHost& host_;
};

/// Told before a lifecycle node's gate closes, while what it publishes and answers still leaves. Runs on the node's executor, alone.
class GateListener {
 public:
  virtual ~GateListener() = default;
  virtual void before_gate_closes() noexcept = 0;
};

/// A named participant of the graph, in rclcpp's words. Always active; most components are LifecycleNodes.
///
/// Publishers, subscriptions, services, parameters and frames are declared in the constructor, which touches no hardware.
/// Threads: everything here belongs to the component's executor, except const members and fault() of LifecycleNode; where a
///          component's callback groups overlap, it sees to its own locks.
/// Errors:  rclcpp's named exceptions for what a programmer or a launch file got wrong.
class Node {
 public:
  Node(const std::string& default_name, const NodeOptions& options);
  virtual ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  [[nodiscard]] const std::string& get_name() const { return identity_.name; }
  [[nodiscard]] const std::string& get_namespace() const { return identity_.name_space; }
  [[nodiscard]] std::string get_fully_qualified_name() const { return identity_.fully_qualified(); }
  [[nodiscard]] const Logger& get_logger() const { return logger_; }
  /// ROS time: what goes into a header's stamp.
  [[nodiscard]] WallTime now() const { return host_->clock().wall_now(); }
  /// The clock of now(), as rclcpp's: `get_clock()->now()`.
  [[nodiscard]] const RosClock* get_clock() const { return &ros_clock_; }
  /// The host's clocks. Its now() is the monotonic one, for pauses, limits and ages of what has no stamp.
  [[nodiscard]] const Clock& steady_clock() const { return host_->clock(); }

  /// Topic names are relative, private (~/) or absolute; remaps and the launch file's QoS apply.
  template <typename T>
  std::shared_ptr<Publisher<T>> create_publisher(const std::string& topic, const QoS& qos,
                                                 const PublisherOptions& options = {}) {
    EndpointSpec spec = endpoint(topic, T::message_type(), qos, true);
    auto events = make_events(spec, options);
    auto writer = make_writer(spec);
    return std::make_shared<Publisher<T>>(spec.topic, spec.qos, std::move(writer), std::move(events));
  }

  /// The callback's first parameter is the wish: `const T&` or `std::shared_ptr<const T>` shares, `Loan<T>` or `std::shared_ptr<T>`
  /// (or, at the price of a heap node, `std::unique_ptr<T>`) owns. A second parameter `const MessageInfo&` is optional. Any callable
  /// will do, std::bind's too; of one that takes several of these, the first here counts.
  template <typename T, typename F>
  std::shared_ptr<Subscription<T>> create_subscription(const std::string& topic, const QoS& qos, F&& callback,
                                                       const SubscriptionOptions& options = {}) {
    using Made = detail::CallbackSubscription<T, std::decay_t<F>>;
    EndpointSpec spec = endpoint(topic, T::message_type(), qos, false);
    auto made = std::make_shared<Made>(spec.topic, spec.qos, std::forward<F>(callback));
    auto events = make_events(spec, options);
    made->attach(make_subscription(spec, detail::kTaking<T, detail::FirstArgument<T, std::decay_t<F>>>,
                                   {&Made::run, made.get()}, options),
                 std::move(events));
    return made;
  }

  /// Of the monotonic clock, whatever the simulation does: for watchdogs and all that real hardware waits for.
  /// Errors: std::invalid_argument for a period that is not positive.
  template <typename F>
  std::shared_ptr<Timer> create_wall_timer(Duration period, F&& callback, CallbackGroup::SharedPtr group = nullptr) {
    return create_timer_of(TimerClock::Monotonic, period, std::forward<F>(callback), group);
  }
  /// Of the node's clock, as rclcpp's: with use_sim_time it follows /clock (see Timer), else it is a wall timer.
  /// Errors: std::invalid_argument for a period that is not positive.
  template <typename F>
  std::shared_ptr<Timer> create_timer(Duration period, F&& callback, CallbackGroup::SharedPtr group = nullptr) {
    return create_timer_of(TimerClock::OfNode, period, std::forward<F>(callback), group);
  }

  /// Lets any thread run the callback on this component's executor.
  template <typename F>
  std::shared_ptr<WakeUp> create_wake_up(F&& callback, const CallbackGroup::SharedPtr& group = nullptr) {
    using Made = detail::CallbackWakeUp<std::decay_t<F>>;
    auto made = std::make_shared<Made>(std::forward<F>(callback));
    made->attach(host_->create_status_event({&Made::run, made.get()}, group));
    return made;
  }

  /// The callback takes (const S::Request&, S::Response&), or both as std::shared_ptr as in rclcpp; or (const RequestId&,
  /// const S::Request&), and the answer follows with Service::send_response().
  template <typename S, typename F>
  std::shared_ptr<Service<S>> create_service(const std::string& name, F&& callback,
                                             CallbackGroup::SharedPtr group = nullptr) {
    using Made = detail::CallbackService<S, std::decay_t<F>>;
    const std::string full = resolve_service_name(name);
    auto made = std::make_shared<Made>(full, std::forward<F>(callback));
    made->attach(host_->create_service(full, S::Request::message_type(), S::Response::message_type(),
                                       {&Made::run, made.get()}, group));
    return made;
  }
  template <typename S>
  std::shared_ptr<Client<S>> create_client(const std::string& name, CallbackGroup::SharedPtr group = nullptr) {
    const std::string full = resolve_service_name(name);
    auto made = std::make_shared<Client<S>>(full);
    made->attach(host_->create_client(full, S::Request::message_type(), S::Response::message_type(),
                                      {&Client<S>::run, made.get()}, group));
    return made;
  }

  /// Creates a group; its type says whether its callbacks may overlap (see CallbackGroup). The create_ functions above take one
  /// and throw std::runtime_error for a group of another node.
  [[nodiscard]] CallbackGroup::SharedPtr create_callback_group(CallbackGroupType type) {
    return host_->create_callback_group(type);
  }

  /// Declares a parameter and returns its value: the override of the launch file, or the default.
  /// Errors: ParameterAlreadyDeclared, InvalidParameterType, InvalidParameterValue (range), with node, name and value.
  template <typename T>
  typename detail::StoredAs<T>::type declare_parameter(const std::string& name, const T& default_value,
                                                       ParameterDescriptor descriptor = {}) {
    using Stored = typename detail::StoredAs<T>::type;
    ParameterValue value{std::in_place_type<Stored>};
    if constexpr (std::is_same_v<T, std::vector<int>>) {
      value = Stored(default_value.begin(), default_value.end());
    } else {
      value = static_cast<Stored>(default_value);
    }
    const ParameterType type = type_of(value);
    return std::get<Stored>(parameters_.declare(name, std::move(value), type, std::move(descriptor)));
  }
  std::string declare_parameter(const std::string& name, const char* default_value,
                                ParameterDescriptor descriptor = {}) {
    return declare_parameter<std::string>(name, default_value, std::move(descriptor));
  }
  /// Declares a parameter without a default; it stays NotSet unless overridden.
  const ParameterValue& declare_parameter(const std::string& name, ParameterType type,
                                          ParameterDescriptor descriptor = {}) {
    return parameters_.declare(name, ParameterValue{}, type, std::move(descriptor));
  }
  [[nodiscard]] bool has_parameter(const std::string& name) const { return parameters_.has(name); }
  [[nodiscard]] Parameter get_parameter(const std::string& name) const { return {name, parameters_.get(name)}; }
  /// Returns false, and leaves `value` as it is, if there is no such parameter or it is not set. Errors: InvalidParameterType.
  template <typename T>
  bool get_parameter(const std::string& name, T& value) const {
    if (!parameters_.has(name) || type_of(parameters_.get(name)) == ParameterType::NotSet) return false;
    value = get_parameter(name).template get_value<T>();
    return true;
  }
  /// The same with another value where there is none.
  template <typename T>
  bool get_parameter_or(const std::string& name, T& value, const T& alternative) const {
    const bool found = get_parameter(name, value);
    if (!found) value = alternative;
    return found;
  }
  template <typename T>
  [[nodiscard]] T get_parameter_or(const std::string& name, const T& alternative) const {
    T value = alternative;
    static_cast<void>(get_parameter(name, value));
    return value;
  }
  /// Errors: ParameterNotDeclared.
  [[nodiscard]] std::vector<Parameter> get_parameters(const std::vector<std::string>& names) const {
    std::vector<Parameter> all;
    for (const auto& name : names) all.push_back(get_parameter(name));
    return all;
  }
  [[nodiscard]] ListParametersResult list_parameters(const std::vector<std::string>& prefixes,
                                                     std::uint64_t depth) const {
    return listed(parameters_.list(), prefixes, depth);
  }
  /// Errors: ParameterNotDeclared, ParameterImmutable (read-only), InvalidParameterType (its type is fixed).
  void undeclare_parameter(const std::string& name) { parameters_.undeclare_dynamic(name); }
  /// The stored alternative: bool, int64_t, double, string or a vector of those.
  template <typename T>
  [[nodiscard]] T get(const std::string& name) const {
    return std::get<T>(parameters_.get(name));
  }
  SetParametersResult set_parameter(const Parameter& parameter) { return parameters_.set_atomically({parameter}); }
  SetParametersResult set_parameters_atomically(const std::vector<Parameter>& parameters) {
    return parameters_.set_atomically(parameters);
  }
  /// The callback is called as long as the handle lives. Callbacks run newest first.
  [[nodiscard]] OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(
      OnSetParametersCallbackHandle::Callback callback) {
    return parameters_.add_on_set(std::move(callback));
  }
  void remove_on_set_parameters_callback(const OnSetParametersCallbackHandle* handle) {
    parameters_.remove_on_set(handle);
  }
  [[nodiscard]] const ParameterStore& parameters() const { return parameters_; }
  [[nodiscard]] ParameterStore& parameters() { return parameters_; }

  /// Claims the transform parent -> child. `origin` names the setting that switches the broadcast off, e.g.
  /// "parameter publish_tf"; conflicts are reported with it.
  std::unique_ptr<FrameClaim> claim_frame(const std::string& parent, const std::string& child,
                                          FrameClaimKind kind = FrameClaimKind::Primary, const Place& origin = {}) {
    return host_->claim_frame(parent, child, kind, origin);
  }

  // For the constructor, so that a launch file can be checked without a robot (design D3):
  /// Declares that this node's data is in `frame`, which `parameter` names. The check requires the frame in the robot's tree.
  void declare_frame_use(const std::string& frame, const std::string& parameter) {
    frame_uses_.push_back({frame, parameter});
  }
  /// Declares that this node opens `path`, which `parameter` names, exclusively. The check reports a second component that does.
  void declare_device_use(const std::string& path, const std::string& parameter) {
    device_uses_.push_back({path, parameter});
  }
  /// Reports a configuration error beyond a parameter's type and range. `nacelle check` shows it; on_configure must refuse it.
  void declare_problem(const Problem& problem) const;
  /// Reports a configuration warning. A warning does not stop the launch.
  void declare_warning(const Problem& problem) const;
  [[nodiscard]] const std::vector<FrameUse>& frame_uses() const { return frame_uses_; }
  [[nodiscard]] const std::vector<DeviceUse>& device_uses() const { return device_uses_; }

  /// The container's one object of that name, e.g. the transform buffer. `make` lives in a library that is never unloaded.
  template <typename T>
  std::shared_ptr<T> shared_object(const std::string& name, std::shared_ptr<void> (*make)()) {
    return std::static_pointer_cast<T>(host_->shared_object(name, make));
  }
  /// Registers an object that must end its work before the gate closes (action servers). Remove it before it is destroyed.
  void add_gate_listener(GateListener& listener) { gate_listeners_.push_back(&listener); }
  void remove_gate_listener(GateListener& listener) { std::erase(gate_listeners_, &listener); }

  DurationHistogram& create_histogram(const std::string& name) { return host_->create_histogram(name); }
  void register_safe_stop(int descriptor, ByteView frame) { host_->register_safe_stop(descriptor, frame); }
  void clear_safe_stop() { host_->clear_safe_stop(); }

  /// The names after expansion and remapping. Errors: InvalidNameError.
  [[nodiscard]] std::string resolve_topic_name(const std::string& name) const;
  [[nodiscard]] std::string resolve_service_name(const std::string& name) const;

 protected:
  [[nodiscard]] NodeHost& host() { return *host_; }
  void close_gate();

 private:
  EndpointSpec endpoint(const std::string& topic, const msgs::MessageType& type, const QoS& qos, bool publisher) const;
  std::unique_ptr<detail::PublisherEvents> make_events(EndpointSpec& spec, const PublisherOptions& options);
  std::unique_ptr<detail::SubscriptionEvents> make_events(EndpointSpec& spec, const SubscriptionOptions& options);
  std::unique_ptr<Writer> make_writer(const EndpointSpec& spec);
  std::unique_ptr<SubscriptionHandle> make_subscription(const EndpointSpec& spec, Taking taking,
                                                        MessageCallback callback, const SubscriptionOptions& options);
  template <typename F>
  std::shared_ptr<Timer> create_timer_of(TimerClock clock, Duration period, F&& callback,
                                         const CallbackGroup::SharedPtr& group) {
    using Made = detail::CallbackTimer<std::decay_t<F>>;
    auto made = std::make_shared<Made>(std::forward<F>(callback));
    made->attach(make_timer(clock, period, {&Made::run, made.get()}, group));
    return made;
  }
  std::unique_ptr<TimerHandle> make_timer(TimerClock clock, Duration period, PlainCallback callback,
                                          const CallbackGroup::SharedPtr& group);

  NodeIdentity identity_;
  Logger logger_;
  std::vector<RemapRule> remaps_;
  std::vector<QosOverride> qos_overrides_;
  ParameterStore parameters_;
  std::vector<FrameUse> frame_uses_;
  std::vector<DeviceUse> device_uses_;
  std::vector<GateListener*> gate_listeners_;
  std::unique_ptr<NodeHost> host_;
  const RosClock ros_clock_{*host_};
};

}  // namespace nacelle
