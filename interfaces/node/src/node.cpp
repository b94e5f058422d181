// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/node.hpp"

#include <fmt/format.h>

#include "nacelle/host/remap_notes.hpp"

namespace nacelle {
namespace {

template <typename T>
T or_throw(Result<T, Problem> result) {
  if (!result) throw exceptions::InvalidNameError(result.error());
  return std::move(result).value();
}

NodeIdentity identify(const std::string& default_name, const NodeOptions& options) {
  NodeIdentity identity{options.node_name().empty() ? default_name : options.node_name(),
                        options.node_namespace().empty() ? "/" : options.node_namespace()};
  if (identity.name_space.front() != '/') identity.name_space.insert(0, 1, '/');
  identity.name_space = remap_namespace(identity.name_space, identity.name, options.remap_rules());
  identity.name = remap_node_name(identity.name, options.remap_rules());
  if (const auto ok = validate_node_name(identity.name); !ok) throw exceptions::InvalidNameError(ok.error());
  if (const auto ok = validate_namespace(identity.name_space); !ok) throw exceptions::InvalidNameError(ok.error());
  return identity;
}

// ROS names loggers with dots: "robot1.lidar".
std::string logger_name(const NodeIdentity& identity) {
  std::string name = identity.fully_qualified().substr(1);
  for (char& c : name) {
    if (c == '/') c = '.';
  }
  return name;
}

}  // namespace

Node::Node(const std::string& default_name, const NodeOptions& options)
    : identity_(identify(default_name, options)),
      logger_(logger_name(identity_)),
      remaps_(options.remap_rules()),
      qos_overrides_(options.qos_overrides()),
      parameters_(identity_.fully_qualified(), options.parameter_overrides(), options.parameter_faults()),
      host_(options.context().create_host(identity_)) {
  declare_parameter("use_sim_time", false,
                    {.description = "Take the time from /clock.", .additional_constraints = "", .read_only = true});
  host_->set_parameters(parameters_);
}

Node::~Node() = default;

void Node::close_gate() {
  for (GateListener* listener : gate_listeners_) listener->before_gate_closes();
  host_->set_active(false);
}

void Node::declare_problem(const Problem& problem) const { parameters_.note_fault({problem, false}); }

void Node::declare_warning(const Problem& problem) const { parameters_.note_fault({problem, true}); }

std::string Node::resolve_topic_name(const std::string& name) const {
  const auto full = or_throw(expand_topic_name(name, identity_.name, identity_.name_space));
  const RemapContext context{identity_.name, identity_.name_space, identity_.name};
  RemapNotes::note(full, remaps_, RemapKind::Topic, context);
  return or_throw(remap_topic(full, remaps_, context));
}

std::string Node::resolve_service_name(const std::string& name) const {
  const auto full = or_throw(expand_topic_name(name, identity_.name, identity_.name_space));
  const RemapContext context{identity_.name, identity_.name_space, identity_.name};
  RemapNotes::note(full, remaps_, RemapKind::Service, context);
  return or_throw(remap_service(full, remaps_, context));
}

EndpointSpec Node::endpoint(const std::string& topic, const msgs::MessageType& type, const QoS& qos,
                            bool publisher) const {
  EndpointSpec spec{resolve_topic_name(topic), &type, qos, identity_.fully_qualified()};
  for (const auto& override_ : qos_overrides_) {
    if (override_.for_publisher != publisher) continue;
    const auto full = or_throw(expand_topic_name(override_.topic, identity_.name, identity_.name_space));
    if (full == spec.topic) spec.qos = override_.apply(spec.qos);
  }
  return spec;
}

// A publisher without callbacks needs none: the subscription's side reports mismatches.
std::unique_ptr<detail::PublisherEvents> Node::make_events(EndpointSpec& spec, const PublisherOptions& options) {
  if (!options.event_callbacks.any()) return nullptr;
  auto events = std::make_unique<detail::PublisherEvents>(*host_, options.callback_group, options.event_callbacks);
  spec.status_listener = events->listener();
  return events;
}

std::unique_ptr<detail::SubscriptionEvents> Node::make_events(EndpointSpec& spec, const SubscriptionOptions& options) {
  auto events =
      std::make_unique<detail::SubscriptionEvents>(*host_, options.callback_group, options.event_callbacks, logger_);
  spec.status_listener = events->listener();
  spec.tells_lost = static_cast<bool>(options.event_callbacks.message_lost_callback);
  spec.command_timeout = options.command_timeout;
  spec.unless_offered = options.unless_offered;
  spec.announced = options.announced;
  return events;
}

std::unique_ptr<Writer> Node::make_writer(const EndpointSpec& spec) { return host_->create_writer(spec); }

std::unique_ptr<SubscriptionHandle> Node::make_subscription(const EndpointSpec& spec, Taking taking,
                                                            MessageCallback callback,
                                                            const SubscriptionOptions& options) {
  return host_->create_subscription(spec, taking, callback, options.callback_group);
}

std::unique_ptr<TimerHandle> Node::make_timer(TimerClock clock, Duration period, PlainCallback callback,
                                              const CallbackGroup::SharedPtr& group) {
  if (period <= Duration::zero()) {
    throw std::invalid_argument(fmt::format("node {}: a timer's period must be positive, not {} ns",
                                            get_fully_qualified_name(), period.count()));
  }
  return host_->create_timer(clock, period, callback, group);
}

}  // namespace nacelle
