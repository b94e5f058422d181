// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>

#include "builder.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle::launch {

void Builder::component(const Element& element, Scope& scope) {
  if (!counted(element) || !condition_holds(element, scope)) return;
  ComponentPlan made;
  made.where = at(element.line);
  made.package = text(element, "pkg", scope).value_or("");
  const auto plugin = text(element, "plugin", scope), name = text(element, "name", scope);  // none: that has been told
  if (plugin && plugin->empty())
    report(at(element.find("plugin")->line), LaunchFault::MissingKey, "'plugin' names no class");
  if (name) {
    if (auto ok = validate_node_name(*name); !ok) report(at(element.find("name")->line), ok.error());
  }
  made.plugin = plugin.value_or("");
  made.name = name.value_or("");
  made.namespace_ = node_namespace(element, scope);

  std::vector<ParameterSource> sources = scope.parameters;
  read_parameters(element, scope, "", sources);
  made.parameters = resolve(sources, made.full_name());
  made.remaps = scope.remaps;
  made.remap_lines = scope.remap_lines;
  made.shared_remaps = made.remaps.size();
  read_remaps(element, scope, made.remaps, &made.remap_lines);
  check_remaps(made);
  made.required = flag(element, "required", true, scope);
  if (const auto isolate = word(element, "isolate", {"none", "process"}, scope))
    made.isolate = static_cast<Isolation>(*isolate);
  // launch_ros writes autostart: true and false.
  if (const auto state = word(element, "autostart", {"unconfigured", "inactive", "active", "false", "true"}, scope)) {
    made.target = *state == 4   ? TargetState::Active
                  : *state == 3 ? TargetState::Unconfigured
                                : static_cast<TargetState>(*state);
  }
  if (const auto resume = word(element, "resume", {"inactive", "active"}, scope)) made.resume_active = *resume == 1;
  if (const auto mode = word(element, "thread", {"shared", "own"}, scope)) made.thread.own = *mode == 1;
  if (const auto policy = word(element, "on_fault", {"degrade", "restart", "stop_robot", "restart_container"}, scope))
    made.on_fault.policy = static_cast<FaultPolicy>(*policy);
  for (const auto& node : words_of(element, "after", scope)) {
    made.after.push_back({node, When::Active, "", std::nullopt, at(element.find("after")->line)});
  }
  for (const auto& child : element.children) {
    if (child.name == "qos") read_qos(child, scope, made);
    if (child.name == "after") read_after(child, scope, made);
    if (child.name == "thread") read_thread(child, scope, made.thread);
    if (child.name == "budget") read_budget(child, scope, made);
    if (child.name == "on_fault") read_on_fault(child, scope, made);
    if (child.name != "extra_arg") continue;
    const auto extra = text(child, "name", scope);
    const auto value = text(child, "value", scope);
    if (!extra || !value) continue;
    // launch_ros takes 'true' in quotes for the bool too.
    if (auto typed = value_of_text(*value)) {
      made.extra_arguments.push_back({*extra, std::move(*typed), at(child.line)});
    } else {
      report(at(child.line), typed.error());
    }
  }
  plan_.components.push_back(std::move(made));
}

/// `look: {port: 8080}` is short for a component of the class that `nacelle look` loads.
void Builder::look(const Element& element, Scope& scope) {
  constexpr std::uint64_t kMostPort = 65535;
  ComponentPlan made;
  made.where = at(element.line);
  made.package = "nacelle_look";
  made.plugin = "nacelle::look::LookComponent";
  made.name = text(element, "name", scope).value_or("");
  if (made.name.empty()) made.name = "look";
  if (auto ok = validate_node_name(made.name); !ok) report(at(element.find("name")->line), ok.error());
  made.namespace_ = scope.namespace_;
  made.remaps = scope.remaps;
  made.remap_lines = scope.remap_lines;
  made.shared_remaps = made.remaps.size();
  made.required = false;  // a port that is in use keeps no robot from driving
  std::vector<ParameterSource> sources = scope.parameters;
  if (const auto port = count(element, "port", kMostPort, scope)) {
    sources.push_back({{"port", static_cast<std::int64_t>(*port), at(element.find("port")->line)}, nullptr, "", false});
  }
  if (const auto address = text(element, "address", scope))
    sources.push_back({{"address", *address, at(element.find("address")->line)}, nullptr, "", false});
  made.parameters = resolve(sources, made.full_name());
  plan_.components.push_back(std::move(made));
}

void Builder::read_qos(const Element& element, Scope& scope, ComponentPlan& into) {
  const auto topic = text(element, "topic", scope);
  if (!topic) return;
  std::string full_name = *topic;
  if (!into.name.empty()) {
    const auto full = expand_topic_name(*topic, into.name, into.namespace_);
    if (!full) return report(at(element.line), full.error());
    full_name = *full;
  }
  if (element.children.empty())
    report(at(element.line), LaunchFault::MissingKey, "the topic '" + *topic + "' needs 'publisher' or 'subscription'");
  for (const auto& child : element.children) {
    TopicQos made{
        full_name, child.name == "publisher" ? Side::Publisher : Side::Subscription, {}, std::nullopt, at(child.line)};
    for (const auto& attribute : child.attributes) {
      const auto value = text(child, attribute.name, scope);
      if (!value) continue;
      const auto& keys = qos_keys();
      const bool known = attribute.name == "liveliness_lease_duration" ||
                         std::find(keys.begin(), keys.end(), attribute.name) != keys.end();
      if (!known) continue;  // the schema has told
      if (auto ok = set_policy(made.patch, attribute.name, *value); !ok) report(at(attribute.line), ok.error());
    }
    if (made.patch.profile) {
      if (auto start = environment_.profiles.find(*made.patch.profile)) {
        made.start = *start;
      } else {
        report(at(child.find("profile")->line), start.error());
      }
    }
    for (const auto& other : into.qos) {
      if (other.topic != made.topic || other.side != made.side) continue;
      report(made.where, LaunchFault::Twice,
             "the QoS of '" + made.topic + "' (" + to_text(made.side) +
                 ") stands here a second time; the first is at " + other.where.text());
    }
    into.qos.push_back(std::move(made));
  }
}

void Builder::read_after(const Element& element, Scope& scope, ComponentPlan& into) {
  const auto node = text(element, "node", scope);
  if (!node) return;
  AfterCondition made{*node, When::Active, text(element, "detail", scope).value_or(""),
                      duration(element, "timeout", scope), at(element.line)};
  if (auto when = text(element, "when", scope)) {
    // "first_message(/scan)" is "first_message" with the detail beside it.
    if (const auto open = when->find('('); open != std::string::npos && when->back() == ')') {
      made.detail = when->substr(open + 1, when->size() - open - 2);
      when->resize(open);
    }
    const std::vector<std::string> words{"active", "first_message", "tf", "service"};
    const auto found = std::find(words.begin(), words.end(), *when);
    if (found == words.end())
      return report(at(element.find("when")->line), LaunchFault::WrongValue, "'when' cannot be '" + *when + "'",
                    suggestion(*when, words));
    made.when = static_cast<When>(found - words.begin());
  }
  if (made.timeout == Duration::zero())
    report(at(element.find("timeout")->line), LaunchFault::WrongValue, "a timeout of 0 is over before it begins",
           "leave it out");
  into.after.push_back(std::move(made));
}

void Builder::read_thread(const Element& element, Scope& scope, ThreadPolicy& into) {
  if (const auto mode = word(element, "mode", {"shared", "own"}, scope)) into.own = *mode == 1;
  if (const auto priority = count(element, "priority", 99, scope)) {
    if (*priority == 0) {
      report(at(element.find("priority")->line), LaunchFault::WrongValue, "'priority' must be from 1 to 99",
             "leave it out for an ordinary thread");
    } else {
      into.priority = static_cast<int>(*priority);
    }
  }
  for (const auto& words : words_of(element, "cpus", scope)) {
    std::string_view rest = words;
    while (!rest.empty()) {
      const auto end = std::min(rest.find(','), rest.size());
      const auto one = rest.substr(0, end);
      int cpu = -1;
      const auto [stop, fault] = std::from_chars(one.data(), one.data() + one.size(), cpu);
      if (fault != std::errc{} || stop != one.data() + one.size() || cpu < 0 || cpu > 1023) {
        return report(at(element.find("cpus")->line), LaunchFault::WrongValue,
                      "'cpus' must be numbers from 0 to 1023, not '" + std::string(one.substr(0, 60)) + "'");
      }
      if (std::find(into.cpus.begin(), into.cpus.end(), cpu) == into.cpus.end()) into.cpus.push_back(cpu);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  if (const auto threads = count(element, "threads", 64, scope)) {
    if (*threads == 0)
      report(at(element.find("threads")->line), LaunchFault::WrongValue, "'threads' must be from 1 to 64",
             "leave it out for one thread");
    into.threads = static_cast<std::uint32_t>(std::max<std::uint64_t>(1, *threads));
  }
  if (!into.own && (into.priority != 0 || !into.cpus.empty() || into.threads != 1)) {
    report(at(element.line), LaunchFault::Misplaced, "priority, cpus and threads belong to a thread of one's own",
           "write mode: own, or leave them out");
  }
}

void Builder::read_budget(const Element& element, Scope& scope, ComponentPlan& into) {
  Budget made;
  made.where = at(element.line);
  if (const auto topic = text(element, "topic", scope); topic && !into.name.empty()) {
    const auto full = expand_topic_name(*topic, into.name, into.namespace_);
    if (!full) return report(made.where, full.error());
    made.topic = *full;
  }
  made.max_copies = count(element, "max_copies", 1'000'000, scope);
  made.max_age = duration(element, "max_age", scope);
  if (const auto hz = text(element, "min_hz", scope)) {
    auto number = value_of_type(*hz, ForcedType::Float);
    const double* value = number ? std::get_if<double>(&*number) : nullptr;
    if (value == nullptr || !(*value > 0 && *value <= 1e6)) {
      return report(at(element.find("min_hz")->line), LaunchFault::WrongValue,
                    "'min_hz' must be a number above 0, not '" + hz->substr(0, 60) + "'");
    }
    made.min_hz = *value;
  }
  into.budgets.push_back(std::move(made));
}

void Builder::read_on_fault(const Element& element, Scope& scope, ComponentPlan& into) {
  FaultHandling made;
  made.policy = FaultPolicy::Degrade;
  const Element* limits = &element;
  for (const auto& child : element.children) {
    if (child.name != "restart") continue;
    made.policy = FaultPolicy::Restart;
    limits = &child;
  }
  if (const auto policy = word(element, "policy", {"degrade", "restart", "stop_robot", "restart_container"}, scope))
    made.policy = static_cast<FaultPolicy>(*policy);
  const auto most = count(*limits, "max", 1'000'000, scope);
  const auto backoff = duration(*limits, "backoff", scope);
  if (made.policy != FaultPolicy::Restart && (most || backoff))
    report(at(element.line), LaunchFault::Misplaced, "'max' and 'backoff' belong to the policy restart");
  if (most) made.max_restarts = static_cast<std::uint32_t>(*most);
  if (backoff) made.backoff = *backoff;
  into.on_fault = made;
}

}  // namespace nacelle::launch
