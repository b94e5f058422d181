// SPDX-License-Identifier: Apache-2.0
#include "session/composition.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "loading/plan_json.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/base/names.hpp"

namespace nacelle::session {
namespace {

using launch::TargetState;
using nlohmann::json;

constexpr int kVersion = 1;
constexpr std::size_t kLongest = 4U << 20U, kMostComponents = 1000;
constexpr const char* kFormat = "nacelle_composition";
constexpr const char* kWayOut = "remove the file, or start without --resume";

template <typename Enum, std::size_t N>
Enum enum_of(const json& row, const char* key, const char* const (&words)[N]) {
  const auto& word = row.at(key).get_ref<const std::string&>();
  for (std::size_t i = 0; i < N; ++i) {
    if (word == words[i]) return static_cast<Enum>(i);
  }
  throw std::invalid_argument(fmt::format("'{}' cannot be '{}'", key, word.substr(0, 80)));
}

constexpr const char* kStates[] = {"unconfigured", "inactive", "active"};
constexpr const char* kIsolations[] = {"none", "process"};
constexpr const char* kWhens[] = {"active", "first_message", "tf", "service"};

template <typename Enum, std::size_t N>
const char* word_of(Enum value, const char* const (&words)[N]) {
  return words[std::min(static_cast<std::size_t>(value), N - 1)];
}

Duration duration_of(const json& row, const char* key) {
  const auto ns = row.at(key).get<std::int64_t>();
  if (ns < 0) throw std::invalid_argument(fmt::format("'{}' is negative", key));
  return Duration{ns};
}

json to_json(const ComposedComponent& component) {
  const launch::ComponentPlan& plan = component.plan;
  json row = loading::plan_to_json(plan);
  row["package"] = plan.package;
  row["state"] = word_of(plan.target, kStates);
  row["actuator"] = component.actuator;
  row["resume_active"] = plan.resume_active;
  row["isolate"] = word_of(plan.isolate, kIsolations);
  if (plan.on_fault.policy) {
    row["on_fault"] = {{"policy", to_text(*plan.on_fault.policy)},
                       {"max", plan.on_fault.max_restarts},
                       {"backoff_ns", plan.on_fault.backoff.count()}};
  }
  row["after"] = json::array();
  for (const auto& after : plan.after) {
    json entry{{"node", after.node}, {"when", word_of(after.when, kWhens)}, {"detail", after.detail}};
    if (after.timeout) entry["timeout_ns"] = after.timeout->count();
    row["after"].push_back(std::move(entry));
  }
  return row;
}

// Errors: exceptions, in words for a person.
ComposedComponent component_of(const json& row, const std::string& file) {
  ComposedComponent component;
  launch::ComponentPlan& plan = component.plan;
  plan = loading::plan_from_json(row);
  plan.where = {file, 0};
  plan.package = row.at("package").get<std::string>();
  plan.target = enum_of<TargetState>(row, "state", kStates);
  component.actuator = row.at("actuator").get<bool>();
  plan.resume_active = row.at("resume_active").get<bool>();
  plan.isolate = enum_of<launch::Isolation>(row, "isolate", kIsolations);
  if (row.contains("on_fault")) {
    const json& entry = row.at("on_fault");
    static constexpr const char* kPolicies[] = {"degrade", "restart", "stop_robot", "restart_container"};
    plan.on_fault.policy = enum_of<FaultPolicy>(entry, "policy", kPolicies);
    if (entry.contains("max")) plan.on_fault.max_restarts = entry.at("max").get<std::uint32_t>();
    if (entry.contains("backoff_ns")) plan.on_fault.backoff = duration_of(entry, "backoff_ns");
  }
  for (const json& entry : row.at("after")) {
    launch::AfterCondition after;
    after.node = entry.at("node").get<std::string>();
    after.when = enum_of<launch::When>(entry, "when", kWhens);
    after.detail = entry.at("detail").get<std::string>();
    if (entry.contains("timeout_ns")) after.timeout = duration_of(entry, "timeout_ns");
    after.where = plan.where;
    plan.after.push_back(std::move(after));
  }
  if (plan.plugin.empty()) throw std::invalid_argument("a component has no plugin");
  if (auto valid = validate_node_name(plan.name); !valid) throw std::invalid_argument(valid.error().text());
  if (plan.namespace_.empty() || plan.namespace_.front() != '/')
    throw std::invalid_argument("the namespace '" + plan.namespace_.substr(0, 80) + "' is not absolute");
  if (plan.thread.threads == 0 || plan.thread.threads > 64 || plan.thread.priority < 0 || plan.thread.priority > 99)
    throw std::invalid_argument("the threads of " + plan.full_name() + " are out of range");
  return component;
}

}  // namespace

bool operator==(const ComposedComponent& a, const ComposedComponent& b) { return to_json(a) == to_json(b); }

std::string to_text(const Composition& composition) {
  json all{{kFormat, kVersion},
           {"container", composition.container},
           {"components", json::array()},
           {"emergency_stops", composition.emergency_stops}};
  for (const auto& component : composition.components) all["components"].push_back(to_json(component));
  return all.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

Result<Composition, Problem> parse_composition(std::string_view text, const std::string& where) {
  const auto refuse = [&](std::string what) { return err(Problem{where, std::move(what), kWayOut}); };
  if (auto bounded = check_json_nesting(text); !bounded)
    return refuse("is not a state file of a container: " + bounded.error().text());
  const json all = parse_json_or_discard(text);
  if (all.is_discarded()) return refuse("is not a state file of a container: not JSON, or cut off");
  if (!all.is_object() || !all.contains(kFormat) || !all.at(kFormat).is_number_integer())
    return refuse("is not a state file of a container: it has no " + std::string{kFormat});
  if (const auto version = all.at(kFormat).get<std::int64_t>(); version != kVersion)
    return refuse(fmt::format("has the version {}, and this program reads {}", version, kVersion));
  Composition composition;
  try {
    composition.container = all.at("container").get<std::string>();
    const json& rows = all.at("components");
    if (!rows.is_array() || rows.size() > kMostComponents) return refuse("holds no list of at most 1000 components");
    for (const json& row : rows) {
      composition.components.push_back(component_of(row, where));
      const std::string name = composition.components.back().plan.full_name();
      for (std::size_t i = 0; i + 1 < composition.components.size(); ++i) {
        if (composition.components[i].plan.full_name() == name) return refuse("holds " + name + " twice");
      }
    }
    // Files of before this key have none.
    for (const json& row : all.value("emergency_stops", json::array())) {
      const auto& topic = row.get_ref<const std::string&>();
      if (auto valid = validate_full_topic_name(topic); !valid || composition.emergency_stops.size() >= kMostComponents)
        return refuse("holds an emergency stop that is not a topic: '" + topic.substr(0, 80) + "'");
      composition.emergency_stops.push_back(topic);
    }
  } catch (const std::exception& e) { return refuse(fmt::format("is damaged: {}", e.what())); }
  return composition;
}

Result<std::optional<Composition>, Problem> read_composition(const std::string& file) {
  std::error_code unknown;
  if (std::filesystem::status(file, unknown).type() == std::filesystem::file_type::not_found)
    return std::optional<Composition>{};
  const auto text = read_regular_file(file, kLongest);
  if (!text) return err(Problem{file, text.error().what, kWayOut});
  auto parsed = parse_composition(text.value(), file);
  if (!parsed) return err(parsed.error());
  return std::optional<Composition>{std::move(parsed).value()};
}

launch::Plan resumed(launch::Plan plan, const Composition& composition, const std::string& file) {
  std::vector<launch::ComponentPlan> components;
  bool demoted = false;
  for (const auto& held : composition.components) {
    const auto* const written = plan.find(held.plan.full_name());
    launch::ComponentPlan component = held.plan;
    if (written != nullptr && written->plugin == held.plan.plugin) {
      component = *written;
      component.parameters = held.plan.parameters;
      component.target = held.plan.target;
    } else {
      component.where = {file, 0};
    }
    component.required = false;
    if (held.actuator && !component.resume_active && component.target == TargetState::Active) {
      component.target = TargetState::Inactive;
      demoted = true;
    }
    components.push_back(std::move(component));
  }
  // Components that move the robot come back inactive, so messages and transforms that depend on motion would never
  // arrive.
  if (demoted) {
    for (auto& component : components) {
      for (auto& condition : component.after) condition.when = launch::When::Active;
    }
  }
  // No component waits for one that is restored below active.
  std::set<std::string> below;
  for (const auto& component : components) {
    if (component.target != TargetState::Active) below.insert(component.full_name());
  }
  for (auto& component : components)
    std::erase_if(component.after, [&](const auto& condition) { return below.count(condition.node) != 0; });
  plan.components = std::move(components);
  return plan;
}

Result<void, Problem> CompositionFile::write(const Composition& composition) {
  std::string text = to_text(composition);
  if (text == last_) return {};
  const std::string beside = path_ + ".new";
  const auto fail = [&](const char* what) {
    return err(Problem{path_, fmt::format("{}: {}", what, std::strerror(errno)),
                       "the composition would not survive a crash; give another place with --state FILE"});
  };
  const int descriptor = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) return fail("cannot be written");
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(descriptor, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  // In RAM it costs nothing; on a disk, a name must not come before its content.
  const bool whole = done == text.size() && ::fsync(descriptor) == 0;
  ::close(descriptor);
  if (!whole) return fail("cannot be written whole");
  if (::rename(beside.c_str(), path_.c_str()) != 0) return fail("cannot be put in its place");
  last_ = std::move(text);
  return {};
}

void CompositionFile::remove() {
  ::unlink(path_.c_str());
  last_.clear();
}

}  // namespace nacelle::session
