// SPDX-License-Identifier: Apache-2.0
#include "replay/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <utility>

#include "loading/load_request.hpp"
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"
#include "proof/declared_graph.hpp"

namespace nacelle::replay {
namespace {

constexpr const char* kClock = "/clock";
constexpr std::uint64_t kLookEvery = 1000;  // messages, for progress

WallTime first_time(const record::OrderedMessages& recording) {
  return WallTime{Duration{static_cast<Duration::rep>(recording.first())}};
}

/// Why a component is a driver; empty: it is none.
std::string driver_of(const proof::LoadedComponent& component, const std::vector<proof::Endpoint>& endpoints) {
  if (!component.declared) return {};
  for (const auto& use : component.declared->device_uses)
    return fmt::format("it opens {} ({})", use.path, use.parameter);
  // declare_device_parameters()
  for (const auto& parameter : component.declared->parameters) {
    if (parameter.name == "required_device") return "it has a device";
  }
  const std::string node = component.plan->full_name();
  for (const auto& endpoint : endpoints) {
    if (endpoint.node == node && endpoint.is_command) return "it moves what " + endpoint.topic + " commands";
  }
  return {};
}

std::unique_ptr<runtime::Container> container_for(const launch::Plan& plan, std::vector<std::string> component_folders,
                                                  const Clock& clock) {
  runtime::ContainerOptions options;
  options.name = plan.container.name;
  options.name_space = plan.container.namespace_;
  options.component_path = std::move(component_folders);
  options.run_by_caller = true;
  return std::make_unique<runtime::Container>(std::move(options), clock);
}

}  // namespace

std::vector<Candidate> candidates_of(const proof::InertRobot& inert) {
  const auto endpoints = proof::endpoints_of(inert.container->graph());
  std::vector<Candidate> all;
  for (const auto& component : inert.loaded) {
    Candidate& candidate = all.emplace_back();
    candidate.node = component.plan->full_name();
    candidate.driver = driver_of(component, endpoints);
    candidate.uses_frames = component.declared && !component.declared->frame_uses.empty();
    if (component.failure) candidate.failure = component.failure->what;
    const auto found = inert.container->find(candidate.node);
    for (const auto& endpoint : endpoints) {
      const bool is_beside =
          found && std::ranges::find(found.value().other_nodes, endpoint.node) != found.value().other_nodes.end();
      if ((endpoint.node != candidate.node && !is_beside) || endpoint.topic == kClock) continue;
      (endpoint.publishes ? candidate.publishes : candidate.reads).insert(endpoint.topic);
    }
  }
  return all;
}

Replay::Replay(record::OrderedMessages& recording, const launch::Plan& plan, const std::vector<Role>& roles,
               record::ByteSink& sink, Options options)
    : recording_(recording),
      plan_(plan),
      roles_(roles),
      options_(std::move(options)),
      clock_(first_time(recording)),
      container_(container_for(plan, options_.component_folders, clock_)),
      output_(sink, options_.compression, container_->transport(), clock_,
              [this](std::uint64_t writer) { return inputs_ && inputs_->is_mine(writer); }) {}

Replay::~Replay() = default;

Result<std::vector<Problem>, Problem> Replay::bring_up() {
  std::vector<Problem> left_out;
  if (auto done = load(left_out); !done) return err(done.error());
  write_new_topics();
  if (auto done = trigger(Transition::Configure, left_out); !done) return err(done.error());
  make_inputs();
  if (auto done = trigger(Transition::Activate, left_out); !done) return err(done.error());
  std::set<std::string> claimed;
  for (const auto& frame : container_->frames()) claimed.insert(frame.child);
  inputs_->leave_out_frames(std::move(claimed));
  return left_out;
}

Result<void, Problem> Replay::load(std::vector<Problem>& left_out) {
  const auto& topics = recording_.topics();
  const bool has_clock = std::ranges::find(topics, kClock, &record::OrderedMessages::Topic::name) != topics.end();
  const auto runs = [this](const std::string& node) {
    return std::ranges::any_of(roles_, [&](const Role& role) { return role.node == node && role.runs(); });
  };
  std::vector<lifecycle_manager::ManagedNode> nodes;
  std::map<std::string, Member> loaded;
  for (const auto& component : plan_.components) {
    const std::string node = component.full_name();
    if (!runs(node)) continue;
    auto request = loading::load_request_of(component);
    request.thread = {};
    // Without a recorded /clock the time of the recording is that of all nodes.
    if (!has_clock) request.parameters.erase("use_sim_time");
    const auto made = container_->load(request);
    if (!made) {
      Problem problem = made.error();
      problem.where = component.where;
      problem.what = node + ": " + problem.what;
      if (component.required) return err(std::move(problem));
      left_out.push_back(std::move(problem));
      continue;
    }
    loaded[node] = {&component, made.value().id};
    lifecycle_manager::ManagedNode& entry = nodes.emplace_back();
    entry.name = node;
    for (const auto& after : component.after) {
      if (runs(after.node)) entry.after.push_back({after.node, after.where});
    }
  }
  for (auto& node : nodes) std::erase_if(node.after, [&](const auto& after) { return !loaded.contains(after.node); });
  auto order = lifecycle_manager::bring_up_order(std::move(nodes));
  if (!order) return err(order.error());
  for (const auto& node : *order) members_.push_back(loaded[node.name]);
  return {};
}

Result<void, Problem> Replay::trigger(Transition transition, std::vector<Problem>& left_out) {
  using launch::TargetState;
  for (auto member = members_.begin(); member != members_.end();) {
    const TargetState target = member->plan->target;
    const bool takes_part =
        target != TargetState::Unconfigured && (target == TargetState::Active || transition == Transition::Configure);
    const auto found = container_->find(std::to_string(member->id));
    if (!takes_part || !found || !found.value().managed) {
      ++member;
      continue;
    }
    const auto outcome = container_->trigger(member->id, transition);
    static_cast<void>(container_->step());
    write_new_topics();
    if (outcome.success) {
      ++member;
      continue;
    }
    Problem problem{member->plan->where, fmt::format("{} could not {}: {}", member->plan->full_name(),
                                                     nacelle::to_text(transition), outcome.reason)};
    if (member->plan->required) return err(std::move(problem));
    left_out.push_back(std::move(problem));
    static_cast<void>(container_->unload(member->id));
    member = members_.erase(member);
  }
  return {};
}

/// Writes the topics that components publish, in the order of their names.
void Replay::write_new_topics() {
  std::map<std::string, std::vector<QoS>> offered;
  for (const auto& endpoint : proof::endpoints_of(container_->graph())) {
    if (endpoint.publishes) offered[endpoint.topic].push_back(endpoint.qos);
  }
  for (const auto& [topic, qos] : offered) {
    if (const auto* const type = container_->topic_type(topic)) output_.add(topic, *type, qos);
  }
}

void Replay::make_inputs() {
  std::set<std::string> published;
  for (const auto& [topic, count] : output_.messages()) published.insert(topic);
  inputs_.emplace(recording_, container_->transport(), options_.find_type, published);
}

/// Runs what is ready and, each at its time, what becomes due until then.
void Replay::run_until(WallTime time) {
  const MonotonicTime end = clock_.monotonic_of(time);
  // What was due has run: a deadline that does not move is no reason to stand still.
  for (MonotonicTime due = container_->step(); due > clock_.now() && due <= end; due = container_->step())
    clock_.advance_to(due);
  clock_.advance_to(end);
}

bool Replay::run(const std::function<bool(double)>& goes_on) {
  const WallTime end{Duration{static_cast<Duration::rep>(recording_.last())}};
  const double length_s = std::max(to_seconds(end - first_time(recording_)), 1e-9);
  std::uint64_t count = 0;
  bool is_whole = true;
  for (const auto* next = inputs_->next(); next != nullptr && !output_.has_failed(); next = inputs_->next()) {
    if (++count % kLookEvery == 0 && !goes_on(to_seconds(inputs_->next_time() - first_time(recording_)) / length_s)) {
      is_whole = false;
      break;
    }
    const bool is_written = options_.writes_inputs && inputs_->next_is_played();
    if (is_written || inputs_->next_has_reader()) run_until(inputs_->next_time());
    if (is_written) output_.write(recording_.topics()[next->topic], *next);
    inputs_->publish_next();
  }
  if (is_whole) run_until(end);
  static_cast<void>(container_->step());
  return output_.finish();
}

ReplayFigures Replay::figures() const {
  ReplayFigures figures;
  if (inputs_) figures.inputs = inputs_->figures();
  figures.outputs = output_.messages();
  figures.seconds = to_seconds(clock_.wall_now() - first_time(recording_));
  return figures;
}

}  // namespace nacelle::replay
