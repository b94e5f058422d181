// SPDX-License-Identifier: Apache-2.0
#include "remote/remote_network.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "nacelle/base/printable.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/runtime/service_fault.hpp"
#include "nacelle/transport_dds/mirror.hpp"
#include "networking/network_wish.hpp"
#include "transport_dds/wire/names.hpp"

namespace nacelle::remote {
namespace {

using nlohmann::json;

// Discovery has no notification, so waiting is done by polling at this period.
constexpr Duration kLook = 10ms;
// Fast DDS 2.9 takes a second to answer a new endpoint or participant: its heartbeats have that period, and it ignores
// the first request, which Cyclone numbers 0.
constexpr Duration kMeeting = 1500ms;
constexpr const char* kOption = "--remote";

/// What is to be in force, as a launch file would ask for it.
Result<launch::NetworkPlan, Problem> plan_of(const RemoteOptions& options, transport_dds::Environment& environment) {
  launch::NetworkPlan plan;
  plan.mode = options.mode;
  plan.domain_id = options.domain;
  if (options.domain) environment.erase("ROS_DOMAIN_ID");  // an option that differs is no conflict
  if (plan.mode) return plan;
  auto asked = networking::network_in_force(plan, environment);
  if (!asked) return err(asked.error());
  // A robot is local by default, but a user of --remote usually means other machines.
  if (asked.value().because_of.empty()) plan.mode = launch::NetworkMode::Export;
  return plan;
}

}  // namespace

RemoteNetwork::RemoteNetwork(const RemoteOptions& options)
    : spin_time_(options.spin_time),
      node_("/_nacelle_cli_" + std::to_string(::getpid())),
      types_(options.message_folders),
      clients_(node_, [this] { bell_.ring(); }) {}

RemoteNetwork::~RemoteNetwork() {
  // The network's thread sends the remaining messages of an endpoint that ends.
  constexpr Duration kLastWords = 500ms;
  if (network_) {
    interrupts_.clear();
    static_cast<void>(wait(clock_.now() + kLastWords, [&] { return network_->writer_count() == 0; }));
  }
}

Result<std::unique_ptr<RemoteNetwork>, Problem> RemoteNetwork::join(const RemoteOptions& options) {
  std::unique_ptr<RemoteNetwork> network{new RemoteNetwork{options}};
  if (auto started = network->start(options); !started) return err(started.error());
  return network;
}

Result<void, Problem> RemoteNetwork::start(const RemoteOptions& options) {
  if (!networking::network_is_built_in()) return err(networking::network_is_not_built_in(kOption));
  transport_dds::Environment environment = networking::ros_environment();
  auto plan = plan_of(options, environment);
  if (!plan) return err(plan.error());
  const auto say = [](const std::string& line) { std::fprintf(stderr, "%s\n", printable_entry(line).c_str()); };
  network_ = std::make_unique<networking::Network>(std::move(plan).value(), std::move(environment), broker_, clients_,
                                                   clock_, say);
  network_->tell_problems_to([this](const Problem& problem) { note(problem); });
  found_by_ = clock_.now() + spin_time_;
  if (auto started = network_->start(); !started) return started;
  const json state = network_->state();
  if (const json& problem = state["problem"]; !problem.is_null()) return err(problem.get<Problem>());
  if (!state["running"].get<bool>()) {
    return err(Problem{kOption, "the network is off: " + state["because_of"].get<std::string>() + " says so",
                       "set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET, or give --network export"});
  }
  where_ = fmt::format("domain {}", state["domain"].get<int>());
  return {};
}

void RemoteNetwork::note(const Problem& problem) {
  if (problem.code.empty()) {
    std::fprintf(stderr, "nacelle: warning: %s\n", problem.text().c_str());
    return;
  }
  problems_.lock()->push_back(problem);
  bell_.ring();
}

bool RemoteNetwork::find(const std::function<bool()>& holds) {
  return find_until(std::max(found_by_, clock_.now() + spin_time_), holds);
}

void RemoteNetwork::find_all(const std::function<bool()>& holds) { static_cast<void>(find_until(found_by_, holds)); }

bool RemoteNetwork::find_until(MonotonicTime until, const std::function<bool()>& holds) {
  if (wait(until, holds)) return true;
  const auto awaits_endpoints = [&] { return look([](const auto& graph) { return graph.awaits_endpoints(); }); };
  if (!awaits_endpoints()) return false;
  // Once the first endpoints of a participant have arrived, the others follow.
  constexpr Duration kRest = 200ms;
  const bool came = wait(std::max(until, found_by_ + kMeeting), [&] { return holds() || !awaits_endpoints(); });
  return came ? wait(clock_.now() + kRest, holds) : holds();
}

bool RemoteNetwork::wait(MonotonicTime until, const std::function<bool()>& holds) {
  std::vector<pollfd> waits{{bell_.descriptor(), POLLIN, 0}};
  for (const int interrupt : interrupts_) waits.push_back({interrupt, POLLIN, 0});
  for (;;) {
    if (holds()) return true;
    const Duration left = until - clock_.now();
    if (left <= 0ns) return false;
    ::poll(waits.data(), waits.size(), static_cast<int>(std::min(left, kLook) / 1ms) + 1);
    if (std::any_of(waits.begin() + 1, waits.end(), [](const pollfd& wait) { return wait.revents != 0; })) return false;
    drain();
  }
}

void RemoteNetwork::drain() { bell_.silence(); }

EndpointSpec RemoteNetwork::spec_of(std::string topic, const msgs::MessageType& type, const QoS& qos) const {
  return {.topic = std::move(topic), .type = &type, .qos = qos, .node = node_};
}

const msgs::MessageType& RemoteNetwork::bytes_of(const std::string& type, const std::string& hash) {
  auto& known = byte_types_[{type, hash}];
  if (!known)
    known = std::make_unique<msgs::ByteMessageType>(
        type, transport_dds::dds_type_name(type).value_or(std::string{type}), hash);
  return known->type();
}

std::optional<Problem> RemoteNetwork::problem_of(const std::string& where) const {
  auto problems = problems_.lock();
  const auto found = std::ranges::find(*problems, Place{where}, &Problem::where);
  return found == problems->end() ? std::nullopt : std::optional<Problem>(*found);
}

// --- calls -----------------------------------------------------------------------------------------------------------

Problem RemoteNetwork::why_not(const std::string& service, const msgs::ServiceType& type) const {
  const std::string what = "service " + service;
  if (auto problem = problem_of(what)) return *problem;
  const auto all = look([](const auto& graph) { return graph.services(); });
  const auto found = all.find(service);
  if (found == all.end()) {
    std::vector<std::string> names;
    for (const auto& [name, types] : all) names.push_back(name);
    return {what, "no server offers it in " + where_,
            names.empty() ? "no service at all was found there" : suggestion(service, names)};
  }
  if (!found->second.contains(type.name))
    return {what, "has the type " + nacelle::join({found->second.begin(), found->second.end()}) + ", not " + type.name,
            ""};
  return {what, "was found in " + where_ + ", and its server has not met this client in time", "give --spin-time more"};
}

Result<std::unique_ptr<runtime::ServiceCall>, Problem> RemoteNetwork::start_call(const std::string& service,
                                                                                 const msgs::ServiceType& type,
                                                                                 void* request,
                                                                                 std::function<void()> on_answer) {
  const std::uint64_t client = clients_.client_of(service, type);
  const auto is_settled = [&] { return clients_.is_ready(client) || problem_of("service " + service); };
  // A discovered server that may need a moment more to match.
  const auto is_offered = [&] {
    return look([&](const auto& graph) {
      return std::ranges::any_of(graph.ends_of_service(service), [&](const auto& end) {
        return !end.is_writer && transport_dds::service_of_half(end.type) == type.name;
      });
    });
  };
  if (!find(is_settled) && is_offered()) static_cast<void>(wait(clock_.now() + kMeeting, is_settled));
  if (!clients_.is_ready(client)) return err(why_not(service, type));
  auto call = std::make_unique<RemoteCall>(std::move(on_answer));
  msgs::AnyMessage given{type.request()};
  type.request().move_assign(given.get(), request);
  if (!clients_.call(client, {call->asker(), std::move(given)}))
    return err(
        Problem{"service " + service, "its server has gone", "try again", runtime::ServiceFault::ServerGone, service});
  return std::unique_ptr<runtime::ServiceCall>(std::move(call));
}

Result<void, Problem> RemoteNetwork::prepare(const std::string& service, const char* type) {
  auto found = types_.find(type);
  if (!found) return err(found.error());
  static_cast<void>(clients_.client_of(service, *found.value().service));
  return {};
}

}  // namespace nacelle::remote
