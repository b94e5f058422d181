// SPDX-License-Identifier: Apache-2.0
// Rules about missing sources: subscriptions without a publisher, clients without a server, exports without a topic.
#include <algorithm>
#include <array>
#include <cctype>

#include "nacelle/base/names.hpp"
#include "nacelle/host/action_names.hpp"
#include "nacelle/host/standard_interfaces.hpp"
#include "proof/rules.hpp"
#include "transport_dds/wire/export_rules.hpp"

namespace nacelle::proof {
namespace {

/// True for topics that people, tools and other programs publish to a robot: the plan needs no publisher.
bool is_from_outside(const Endpoint& reader) {
  static constexpr std::array<std::string_view, 9> kNames{
      "/clock",       "/tf",        "/tf_static",     "/emergency_stop", "/set_pose",
      "/initialpose", "/goal_pose", "/clicked_point", "/diagnostics"};
  const bool named = std::ranges::any_of(kNames, [&](std::string_view name) { return reader.topic.ends_with(name); });
  return named || reader.is_command || reader.type.starts_with("std_msgs/") || reader.type == "sensor_msgs/msg/Joy";
}

std::string without_digits(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0; });
  return text;
}

/// A name that a person may have meant. Two robots' or two sensors' names differ in a number or in a namespace, and are no slip of
/// the pen.
std::string slip_of(const std::string& name, std::vector<std::string> others) {
  const auto parts = std::ranges::count(name, '/');
  std::erase_if(others, [&](const auto& other) {
    return std::ranges::count(other, '/') != parts || without_digits(other) == without_digits(name);
  });
  return nearest_name(name, others);
}

/// The parameter that names the topic or service, or the line of its `qos:`; else the component.
std::string place_of_name(const launch::ComponentPlan& plan, const std::string& full_name) {
  for (const auto& given : plan.parameters) {
    const auto* const value = std::get_if<std::string>(&given.value);
    if (value == nullptr || value->empty()) continue;
    const auto full = expand_topic_name(*value, plan.name, plan.namespace_);
    if (full && *full == full_name) return given.where.text();
  }
  for (std::size_t i = 0; i < plan.remaps.size() && i < plan.remap_lines.size(); ++i) {
    const auto to = expand_topic_name(plan.remaps[i].to, plan.name, plan.namespace_);
    if (to && *to == full_name) return plan.remap_lines[i].text();
  }
  return plan.where.text();
}

const LoadedComponent* component_of(const Evidence& evidence, const std::string& node) {
  const auto found =
      std::ranges::find(evidence.loaded, node, [](const auto& component) { return component.plan->full_name(); });
  return found == evidence.loaded.end() ? nullptr : &*found;
}

/// True if a component could not be made: its topics are unknown, and its absence is reported already.
bool is_any_missing(const Evidence& evidence) {
  return std::ranges::any_of(evidence.loaded, [](const auto& component) { return component.failure.has_value(); });
}

/// Topics of the container itself, which no component has.
bool is_of_the_container(const std::string& name) {
  return is_standard_topic(name) || name == "/diagnostics" || name.find("/_container/") != std::string::npos;
}

}  // namespace

void check_subscriptions(Evidence& evidence) {
  const auto& all = evidence.endpoints;
  const auto on = [&](const std::string& topic, bool publishes, auto&& fits) {
    return std::ranges::any_of(
        all, [&](const Endpoint& end) { return end.topic == topic && end.publishes == publishes && fits(end); });
  };
  const auto any = [](const Endpoint&) { return true; };
  const bool missing = is_any_missing(evidence);
  std::string told;
  for (const Endpoint& reader : all) {
    const LoadedComponent* const component = component_of(evidence, reader.node);
    if (reader.publishes || component == nullptr || reader.is_apart || action::is_action_part(reader.topic) ||
        on(reader.topic, true, any))
      continue;
    if (told == reader.topic + " " + reader.node) continue;  // two types on one topic
    const bool outside = on(reader.topic, false, is_from_outside);
    std::vector<std::string> others;
    for (const Endpoint& writer : all) {
      if (!writer.publishes || writer.type != reader.type) continue;
      // A component that reads one name and publishes the other has written both on purpose.
      if (writer.node == reader.node) continue;
      // Other topics of a command's type are normal, unless they have no reader.
      if (!outside || !on(writer.topic, false, any)) others.push_back(writer.topic);
    }
    const std::string near = slip_of(reader.topic, others);
    if (near.empty() && (outside || missing)) continue;
    told = reader.topic + " " + reader.node;
    const Severity severity = near.empty() || outside ? Severity::Warning : severity_of(*component->plan);
    evidence.find(Rule::NotPublished,
                  {place_of_name(*component->plan, reader.topic),
                   reader.node + " reads '" + reader.topic + "' (" + reader.type + "), which no component publishes",
                   !near.empty()    ? "did you mean '" + near + "'?"
                   : others.empty() ? "fine if another container does, or if it is not needed"
                                    : "of its type there is " + join(others, " and ")},
                  severity);
  }
}

void check_clients(Evidence& evidence) {
  const std::vector<runtime::ServiceReport> all = evidence.container.services();
  const bool missing = is_any_missing(evidence);
  for (const auto& client : all) {
    const LoadedComponent* const component = component_of(evidence, client.node);
    if (client.is_server || component == nullptr) continue;
    // An action is one thing: its first service stands for all of it.
    if (action::is_action_part(client.name) && !client.name.ends_with(action::kSendGoal)) continue;
    std::vector<std::string> others;
    const runtime::ServiceReport* server = nullptr;
    for (const auto& other : all) {
      if (!other.is_server) continue;
      if (other.name != client.name) {
        if (other.type == client.type) others.push_back(other.name);
      } else if (server == nullptr || other.type == client.type) {
        server = &other;
      }
    }
    const std::string place = place_of_name(*component->plan, client.name);
    if (server != nullptr) {
      if (server->type == client.type) continue;
      evidence.find(
          Rule::ServiceTypes,
          {place,
           client.name + ": " + server->node + " offers " + server->type + ", " + client.node + " calls " + client.type,
           "rename one of the services with a remap, or make both sides use one type"},
          severity_of(*component->plan));
      continue;
    }
    const bool is_standard = std::ranges::any_of(evidence.loaded, [&](const LoadedComponent& other) {
      const auto services = standard_services_of(evidence, other);
      return std::ranges::find(services, client.name) != services.end();
    });
    if (is_standard) continue;
    const std::string near = slip_of(client.name, others);
    if (near.empty() && missing) continue;
    evidence.find(
        Rule::NotOffered,
        {place,
         client.node + " calls the service '" + client.name + "' (" + client.type + "), which no component offers",
         !near.empty()    ? "did you mean '" + near + "'?"
         : others.empty() ? "fine if it can do without"
                          : "of its type there is " + join(others, " and ")},
        near.empty() ? Severity::Warning : severity_of(*component->plan));
  }
}

void check_exports(Evidence& evidence) {
  if (is_any_missing(evidence)) return;
  std::vector<std::string> services;
  for (const auto& service : evidence.container.services()) services.push_back(service.name);
  for (const LoadedComponent& component : evidence.loaded) {
    const auto standard = standard_services_of(evidence, component);
    services.insert(services.end(), standard.begin(), standard.end());
    if (component.declared)
      services.insert(services.end(), component.declared->services.begin(), component.declared->services.end());
  }
  std::vector<std::string> names = services;
  for (const Endpoint& end : evidence.endpoints) names.push_back(end.topic);
  for (const launch::ExportPlan& plan : evidence.plan.network.exports) {
    const std::vector<transport_dds::ExportRule> rule{{plan.topic, 0.0, 0, plan.compressed_only}};
    const auto shows = [&](const Endpoint& end) {
      return transport_dds::rule_of(rule, end.topic, end.type) != nullptr;
    };
    if (std::ranges::any_of(evidence.endpoints, shows) || is_of_the_container(plan.topic)) continue;
    const bool is_raw = std::ranges::find(names, plan.topic) != names.end();
    if (is_raw && !plan.compressed_only) continue;  // a service
    const std::string near = is_raw ? std::string{} : slip_of(plan.topic, names);
    evidence.find(Rule::UnusedExport,
                  {plan.where,
                   is_raw ? "no component publishes a compressed form of '" + plan.topic + "': it is not exported"
                          : "export: no node has a topic or service '" + plan.topic + "': this entry exports nothing",
                   is_raw          ? "add what publishes '" + plan.topic + "/compressed', or leave compressed_only out"
                   : !near.empty() ? "did you mean '" + near + "'?"
                                   : "fine if a component that is loaded later has it"},
                  Severity::Warning);
  }
}

}  // namespace nacelle::proof
