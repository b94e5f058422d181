// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/session_services.hpp"

#include <fmt/format.h>

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

#include "nacelle/networking/network_message.hpp"
#include "nacelle/runtime/interface_messages.hpp"
#include "nacelle/session/attempt.hpp"
#include "nacelle/session/comeback.hpp"
#include "nacelle/session/component_details.hpp"
#include "nacelle/session/frames.hpp"
#include "nacelle/session/session.hpp"
#include "nacelle/session/statistics.hpp"

namespace nacelle::session {
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

GetFaults::Response faults_of(Session& session) {
  GetFaults::Response faults = session.supervision().report();
  const std::string file = crash_file_of(session.options().state_file);
  if (const auto crash = read_crash(file)) {
    faults.last_crash = fmt::format("{} (all of it: {})", crash->text, file);
    faults.last_crash_file = file;
  }
  return faults;
}

GetEmergencyStops::Response stops_of(Session& session) {
  GetEmergencyStops::Response stops;
  stops.topics = session.emergency_stops().set();
  return stops;
}

ReleaseEmergencyStops::Response release_stops(Session& session, const ReleaseEmergencyStops::Request& request) {
  ReleaseEmergencyStops::Response response;
  const auto released = session.emergency_stops().release(request.topics);
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

Shutdown::Response shut_down(Session& session) {
  session.request_shutdown();
  Shutdown::Response response;
  response.success = true;
  return response;
}

template <typename Response>
Response network_of(Session& session) {
  Response response;
  response.container = session.options().container_name;
  auto network = networking::network_message(session.network().state());
  response.success = network.has_value();
  if (network) {
    response.network = std::move(network).value();
  } else {
    response.problem = runtime::message_of(network.error());
  }
  return response;
}

SetNetwork::Response set_network(Session& session, const SetNetwork::Request& request) {
  networking::Network& network = session.network();
  const auto mode = request.exported ? launch::NetworkMode::Export : network.unexported();
  if (auto shown = network.show(mode, request.exported ? "nacelle export on" : "nacelle export off"); !shown) {
    SetNetwork::Response refused;
    refused.problem = runtime::message_of(shown.error());
    return refused;
  }
  return network_of<SetNetwork::Response>(session);
}

}  // namespace

SessionServices::SessionServices(Session& session) : session_(session) {
  offer<GetComponent>("get_component", [&session](const auto& request) {
    return details_of(session.container(), session.plan(), request.component);
  });
  offer<GetFaults>("get_faults", [&session](const auto&) { return faults_of(session); });
  offer<GetStatistics>("get_statistics", [&session](const auto&) { return statistics_of(session.container()); });
  offer<GetFrames>("get_frames",
                   [&session](const auto&) { return frames_of(session.container(), session.plan().name_space); });
  offer<LookupTransform>("lookup_transform",
                         [&session](const auto& request) { return transform_of(session.container(), request); });
  offer<GetEmergencyStops>("get_emergency_stops", [&session](const auto&) { return stops_of(session); });
  offer<ReleaseEmergencyStops>("release_emergency_stops",
                               [&session](const auto& request) { return release_stops(session, request); });
  offer<Shutdown>("shutdown", [&session](const auto&) { return shut_down(session); });
  offer_in_serve<GetNetwork>("get_network",
                             [&session](const auto&) { return network_of<GetNetwork::Response>(session); });
  offer_in_serve<SetNetwork>("set_network", [&session](const auto& request) { return set_network(session, request); });
}

template <typename S, typename F>
void SessionServices::offer(const char* name, F answer) {
  keep<S>(name,
          [answer](const typename S::Request& request, typename S::Response& response) { response = answer(request); });
}

template <typename S, typename F>
void SessionServices::offer_in_serve(const char* name, F answer) {
  const auto service = std::make_shared<Service<S>*>(nullptr);  // known before the first serve()
  *service = &keep<S>(name, [this, answer, service](const RequestId& id, const typename S::Request& request) {
    waiting_.lock()->push_back([answer, service, id, request] { (*service)->send_response(id, answer(request)); });
    event_.set();
  });
}

template <typename S, typename Callback>
Service<S>& SessionServices::keep(const char* name, Callback callback) {
  using Made = nacelle::detail::CallbackService<S, Callback>;
  auto made = std::make_shared<Made>(name, std::move(callback));
  made->attach(session_.container().offer_service(name, S::Request::message_type(), S::Response::message_type(),
                                                  {&Made::run, made.get()}));
  services_.push_back(made);
  return *made;
}

void SessionServices::serve() {
  event_.clear();
  const auto waiting = std::exchange(*waiting_.lock(), {});
  for (const auto& answer : waiting) attempt("services", answer);
}

}  // namespace nacelle::session
