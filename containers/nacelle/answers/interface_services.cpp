// SPDX-License-Identifier: Apache-2.0
#include "answers/interface_services.hpp"

#include <nacelle_interfaces/srv/get_component.hpp>
#include <nacelle_interfaces/srv/get_emergency_stops.hpp>
#include <nacelle_interfaces/srv/get_faults.hpp>
#include <nacelle_interfaces/srv/get_frames.hpp>
#include <nacelle_interfaces/srv/get_network.hpp>
#include <nacelle_interfaces/srv/get_statistics.hpp>
#include <nacelle_interfaces/srv/lookup_transform.hpp>
#include <nacelle_interfaces/srv/release_emergency_stops.hpp>
#include <nacelle_interfaces/srv/set_network.hpp>
#include <nacelle_interfaces/srv/shutdown.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "answers/component_details.hpp"
#include "answers/frames.hpp"
#include "answers/statistics.hpp"
#include "nacelle/runtime/interface_messages.hpp"
#include "networking/network_message.hpp"
#include "process/attempt.hpp"

namespace nacelle::answers {
namespace {

using nacelle_interfaces::srv::GetComponent;
using nacelle_interfaces::srv::GetEmergencyStops;
using nacelle_interfaces::srv::GetFaults;
using nacelle_interfaces::srv::GetFrames;
using nacelle_interfaces::srv::GetNetwork;
using nacelle_interfaces::srv::GetStatistics;
using nacelle_interfaces::srv::LookupTransform;
using nacelle_interfaces::srv::ReleaseEmergencyStops;
using nacelle_interfaces::srv::SetNetwork;
using nacelle_interfaces::srv::Shutdown;

GetEmergencyStops::Response stops_of(Robot& robot) {
  GetEmergencyStops::Response stops;
  stops.topics = robot.emergency_stops();
  return stops;
}

ReleaseEmergencyStops::Response release_stops(Robot& robot, const ReleaseEmergencyStops::Request& request) {
  ReleaseEmergencyStops::Response response;
  const auto released = robot.release_emergency_stops(request.topics);
  response.success = released.has_value();
  if (!released) {
    response.problem = runtime::message_of(released.error());
    return response;
  }
  for (const auto& one : released.value()) {
    auto& row = response.released.emplace_back();
    row.topic = one.topic;
    row.readers = one.readers;
  }
  return response;
}

Shutdown::Response shut_down(Robot& robot) {
  robot.request_shutdown();
  Shutdown::Response response;
  response.success = true;
  return response;
}

template <typename Response>
Response network_of(Robot& robot) {
  Response response;
  response.container = robot.name();
  auto network = networking::network_message(robot.network().state());
  response.success = network.has_value();
  if (network) {
    response.network = std::move(network).value();
  } else {
    response.problem = runtime::message_of(network.error());
  }
  return response;
}

SetNetwork::Response set_network(Robot& robot, const SetNetwork::Request& request) {
  networking::Network& network = robot.network();
  const auto mode = request.exported ? launch::NetworkMode::Export : network.unexported();
  if (auto shown = network.show(mode, request.exported ? "nacelle export on" : "nacelle export off"); !shown) {
    SetNetwork::Response refused;
    refused.problem = runtime::message_of(shown.error());
    return refused;
  }
  return network_of<SetNetwork::Response>(robot);
}

}  // namespace

InterfaceServices::InterfaceServices(Robot& robot) : robot_(robot) {
  offer<GetComponent>("get_component",
                      [&robot](const auto& request) { return details_of(robot.container(), request.component); });
  offer<GetFaults>("get_faults", [&robot](const auto&) { return robot.faults(); });
  offer<GetStatistics>("get_statistics", [&robot](const auto&) { return statistics_of(robot.container()); });
  offer<GetFrames>("get_frames",
                   [&robot](const auto&) { return frames_of(robot.container(), robot.plan().name_space); });
  offer<LookupTransform>("lookup_transform",
                         [&robot](const auto& request) { return transform_of(robot.container(), request); });
  offer<GetEmergencyStops>("get_emergency_stops", [&robot](const auto&) { return stops_of(robot); });
  offer<ReleaseEmergencyStops>("release_emergency_stops",
                               [&robot](const auto& request) { return release_stops(robot, request); });
  offer<Shutdown>("shutdown", [&robot](const auto&) { return shut_down(robot); });
  offer_in_serve<GetNetwork>("get_network", [&robot](const auto&) { return network_of<GetNetwork::Response>(robot); });
  offer_in_serve<SetNetwork>("set_network", [&robot](const auto& request) { return set_network(robot, request); });
}

template <typename S, typename F>
void InterfaceServices::offer(const char* name, F answer) {
  keep<S>(name,
          [answer](const typename S::Request& request, typename S::Response& response) { response = answer(request); });
}

template <typename S, typename F>
void InterfaceServices::offer_in_serve(const char* name, F answer) {
  const auto service = std::make_shared<Service<S>*>(nullptr);  // known before the first serve()
  *service = &keep<S>(name, [this, answer, service](const RequestId& id, const typename S::Request& request) {
    waiting_.lock()->push_back([answer, service, id, request] { (*service)->send_response(id, answer(request)); });
    event_.ring();
  });
}

template <typename S, typename Callback>
Service<S>& InterfaceServices::keep(const char* name, Callback callback) {
  using Made = nacelle::detail::CallbackService<S, Callback>;
  auto made = std::make_shared<Made>(name, std::move(callback));
  made->attach(robot_.container().offer_service(name, S::Request::message_type(), S::Response::message_type(),
                                                {&Made::run, made.get()}));
  services_.push_back(made);
  return *made;
}

void InterfaceServices::serve() {
  event_.silence();
  const auto waiting = std::exchange(*waiting_.lock(), {});
  for (const auto& answer : waiting) process::attempt("services", answer);
}

}  // namespace nacelle::answers
