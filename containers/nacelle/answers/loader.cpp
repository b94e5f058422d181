// SPDX-License-Identifier: Apache-2.0
#include "answers/loader.hpp"

#include <algorithm>
#include <future>
#include <iterator>
#include <memory>
#include <utility>

#include "answers/robot_fault.hpp"
#include "loading/wiring.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/names.hpp"

namespace nacelle::answers {
namespace {

struct Clashes {
  std::string within;                // pairs of this container that cannot talk
  ProblemCode code;                  // of the first one
  std::string topic;                 // of the first one
  std::vector<std::string> outside;  // with nodes of the network, which do not prevent loading
};

Clashes clashes_of(const runtime::Container& container, const std::string& node) {
  Clashes found;
  for (const auto& clash : container.clashes()) {
    if (clash.writer_node != node && clash.reader_node != node) continue;
    if (container.find(clash.writer_node).has_value() && container.find(clash.reader_node).has_value()) {
      if (found.within.empty()) {
        found.code = clash.policy == "type" ? RobotFault::TopicTypes : RobotFault::QosMismatch;
        found.topic = clash.topic;
      }
      found.within.append(found.within.empty() ? "" : "; ").append(clash.text());
    } else {
      found.outside.push_back(clash.text());
    }
  }
  return found;
}

loading::TopicEnds ends_of(const loading::GraphBefore& before, const runtime::ComponentInfo& component) {
  loading::TopicEnds ends = before.added();
  if (component.declared) ends.services = {component.declared->services.begin(), component.declared->services.end()};
  return ends;
}

}  // namespace

Loader::Loader(Robot& robot) : robot_(robot) { robot_.container().compose_through(this); }

Loader::~Loader() {
  close();
  robot_.container().compose_through(nullptr);
}

Result<Loader::Loaded, Problem> Loader::load_planned_now(const std::string& name) {
  std::vector<std::string> names;
  for (const auto& component : robot_.plan().components) {
    names.push_back(component.name);
    if (component.full_name() != name && component.name != name) continue;
    const loading::GraphBefore before{robot_.container()};
    auto loaded = robot_.load(component);
    if (!loaded) return err(loaded.error());
    Loaded result{loaded.value(), {}};
    for (const auto& problem : loading::unused_qos(component, ends_of(before, result.component)))
      result.warnings.push_back(problem.text());
    return finish(std::move(result), component.target);
  }
  const std::string nearest = suggestion(name, names);
  return err(Problem{"component " + name, "the launch file has no component of that name",
                     nearest + (nearest.empty() ? "" : "; ") + "a plugin is loaded with its class and --name",
                     NameFault::Unknown, name});
}

Result<Loader::Loaded, Problem> Loader::load_now(runtime::LoadRequest request, launch::TargetState target) {
  const launch::NamespacePlan& names = robot_.plan().name_space;
  request.name_space = join_namespaces(names.path, request.name_space);
  if (const std::string prefix = names.frame_prefix(); !prefix.empty())
    request.parameters.emplace("frame_prefix", prefix);
  const std::size_t own_remaps = request.remaps.size();
  if (names.tf_topic() != "/tf") {
    request.remaps.push_back({RemapKind::Topic, "", "/tf", names.tf_topic()});
    request.remaps.push_back({RemapKind::Topic, "", "/tf_static", names.tf_topic() + "_static"});
  }
  const loading::GraphBefore before{robot_.container()};
  auto loaded = robot_.container().load(request);
  if (!loaded) return err(loaded.error());
  Loaded result{loaded.value(), {}};
  if (const auto& declared = result.component.declared) {
    const loading::TopicEnds ends = ends_of(before, result.component);
    for (const auto& unused :
         loading::unused_remaps(request.remaps, declared->used_remaps, result.component.node, ends))
      if (unused.rule < own_remaps) result.warnings.push_back(unused.problem.text());
  }
  return finish(std::move(result), target);
}

Result<Loader::Loaded, Problem> Loader::finish(Loaded loaded, launch::TargetState target) {
  const runtime::ComponentInfo& component = loaded.component;
  Clashes clashes = clashes_of(robot_.container(), component.node);
  std::ranges::move(clashes.outside, std::back_inserter(loaded.warnings));
  Result<void, Problem> done{};
  if (!clashes.within.empty()) {
    done = err(Problem{component.node, clashes.within, "", clashes.code, clashes.topic});
  } else if (component.managed) {
    done = robot_.bring_to(component, target);
  }
  if (!done) static_cast<void>(robot_.container().unload(component.id));
  robot_.composition_changed();
  if (!done) {
    Problem problem = done.error();
    problem.way_out += problem.way_out.empty() ? "it was unloaded again" : "; it was unloaded again";
    // A misspelt parameter may be why: with the default of the right one the component looked for another device.
    std::ranges::copy(component.warnings, std::back_inserter(loaded.warnings));
    for (const auto& warning : loaded.warnings) problem.way_out += "; " + warning;
    return err(problem);
  }
  if (auto now = robot_.container().find(component.node)) {
    now.value().warnings = std::move(loaded.component.warnings);
    loaded.component = std::move(now).value();
  }
  return loaded;
}

Problem Loader::not_running() const { return why_not_running(robot_); }

// The call goes with the loader's end, and with it the promise of its answer.
template <typename Act>
auto Loader::on_main_thread(Act act) -> decltype(act()) {
  if (robot_.phase() != Phase::Running) return err(not_running());
  auto call = std::make_shared<std::packaged_task<decltype(act())()>>(std::move(act));
  auto answer = call->get_future();
  {
    auto waiting = waiting_.lock();
    if (waiting->closed) return err(not_running());
    waiting->call = [call = std::move(call)] { (*call)(); };
  }
  event_.ring();
  try {
    return answer.get();
  } catch (const std::future_error&) { return err(not_running()); }
}

std::string Loader::name_space() const { return robot_.plan().name_space.path; }

Result<Loader::Loaded, Problem> Loader::load_planned(const std::string& name) {
  return on_main_thread([this, name] { return load_planned_now(name); });
}

Result<Loader::Loaded, Problem> Loader::load(const runtime::LoadRequest& request, bool activate) {
  const auto target = activate ? launch::TargetState::Active : launch::TargetState::Unconfigured;
  return on_main_thread([this, request, target] { return load_now(request, target); });
}

Result<runtime::UnloadOutcome, Problem> Loader::unload(std::uint64_t id) {
  return on_main_thread([this, id] {
    auto outcome = robot_.container().unload(id);
    robot_.composition_changed();
    return outcome;
  });
}

void Loader::serve() {
  event_.silence();
  const auto call = std::exchange(waiting_.lock()->call, {});
  if (call) call();
}

void Loader::close() {
  auto waiting = waiting_.lock();
  waiting->closed = true;
  waiting->call = {};
}

}  // namespace nacelle::answers
