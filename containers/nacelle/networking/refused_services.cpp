// SPDX-License-Identifier: Apache-2.0
#include "networking/refused_services.hpp"

#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <nacelle_interfaces/srv/load_component.hpp>
#include <nacelle_interfaces/srv/release_emergency_stops.hpp>
#include <nacelle_interfaces/srv/set_network.hpp>
#include <nacelle_interfaces/srv/shutdown.hpp>
#include <nacelle_interfaces/srv/unload_component.hpp>

namespace nacelle::networking {
namespace {

namespace ros = composition_interfaces::srv;
namespace own = nacelle_interfaces::srv;

using Refused = std::map<std::string, std::shared_ptr<const msgs::AnyMessage>>;

struct Words {
  const char *what, *way_out;
};
constexpr Words kNoLoad{
    "this container refuses to load and unload for callers on the network",
    "set `network: {allow_load: true}` in its launch file, or use `nacelle component` on its machine"};
constexpr Words kNoControl{"this container refuses this for callers on the network",
                           "set `network: {remote_control: true}` in its launch file, or ask on its machine"};

template <typename S>
void refuse(Refused& refused, const std::string& node, const char* name, const Words& words) {
  const std::string service = node + "/_container/" + name;
  auto response = std::make_shared<msgs::AnyMessage>(S::Response::message_type());
  auto& out = *static_cast<typename S::Response*>(response->get());
  if constexpr (requires { out.error_message; }) {
    out.error_message = std::string{words.what} + ": " + words.way_out;
  } else {
    out.problem.where = service;
    out.problem.what = words.what;
    out.problem.way_out = words.way_out;
  }
  refused.emplace(service, std::move(response));
}

}  // namespace

Refused refused_services(const std::string& node, const transport_dds::NetworkSettings& settings) {
  Refused refused;
  if (!settings.allow_load) {
    refuse<ros::LoadNode>(refused, node, "load_node", kNoLoad);
    refuse<ros::UnloadNode>(refused, node, "unload_node", kNoLoad);
    refuse<own::LoadComponent>(refused, node, "load_component", kNoLoad);
    refuse<own::UnloadComponent>(refused, node, "unload_component", kNoLoad);
  }
  if (!settings.remote_control && !settings.secured) {
    refuse<own::ReleaseEmergencyStops>(refused, node, "release_emergency_stops", kNoControl);
    refuse<own::SetNetwork>(refused, node, "set_network", kNoControl);
    refuse<own::Shutdown>(refused, node, "shutdown", kNoControl);
  }
  return refused;
}

}  // namespace nacelle::networking
