// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/plan.hpp"

#include "nacelle/qos/text.hpp"

namespace nacelle::launch {
namespace {

class Text {
 public:
  void line(int depth, const std::string& text) {
    all += std::string(static_cast<std::size_t>(depth) * 2, ' ') + text + "\n";
  }
  void parameters(int depth, const char* word, const std::vector<Parameter>& list) {
    for (const auto& p : list)
      line(depth, std::string(word) + " " + p.name + " = " + type_name(p.value) + " " + to_text(p.value));
  }
  std::string all;
};

std::string text_or_none(const std::optional<Duration>& d) { return d ? nacelle::to_text(*d) : "none"; }

std::string text_of(const FaultHandling& on_fault) {
  if (!on_fault.policy) return {};
  return std::string(", on_fault ") + nacelle::to_text(*on_fault.policy) + " max " +
         std::to_string(on_fault.max_restarts) + " backoff " + nacelle::to_text(on_fault.backoff);
}

void describe(Text& out, const ComponentPlan& c) {
  out.line(0, "component " + c.full_name() + " = " + c.package + " " + c.plugin);
  out.parameters(1, "param", c.parameters);
  for (const auto& rule : c.remaps) out.line(1, "remap " + nacelle::to_text(rule));
  out.parameters(1, "extra_arg", c.extra_arguments);
  for (const auto& q : c.qos) {
    out.line(1, "qos " + q.topic + " " + to_text(q.side) +
                    " over the defaults = " + nacelle::to_text(q.applied_to(QoS(10))) + ", over other values = " +
                    nacelle::to_text(q.applied_to(QoS(KeepAll()).best_effort().transient_local())));
  }
  for (const auto& a : c.after) {
    out.line(1, "after " + a.node + " " + to_text(a.when) + " " + a.detail + " timeout " + text_or_none(a.timeout));
  }
  std::string thread = std::string("thread ") + (c.thread.own ? "own" : "shared");
  if (c.thread.priority != 0) thread += " priority " + std::to_string(c.thread.priority);
  for (const int cpu : c.thread.cpus) thread += " cpu " + std::to_string(cpu);
  if (c.thread.threads != 1) thread += " threads " + std::to_string(c.thread.threads);
  out.line(1, thread);
  out.line(1, std::string("required ") + (c.required ? "true" : "false") + ", autostart " + to_text(c.target) +
                  ", isolate " + (c.isolate == Isolation::None ? "none" : "process") +
                  (c.resume_active ? ", resume active" : "") + text_of(c.on_fault));
}

void describe(Text& out, const ProgramPlan& p) {
  out.line(0, "program " + p.label + " = " + p.package + " " + p.executable);
  for (const auto& word : p.command_arguments()) out.line(1, "word " + word);
  for (const auto& [name, value] : p.environment) out.line(1, "env " + name + (value ? "=" + *value : " unset"));
  out.line(1, "cwd " + p.working_directory + ", output " + p.output + ", required " + (p.required ? "true" : "false"));
  out.line(
      1, "sigterm_timeout " + text_or_none(p.sigterm_timeout) + ", sigkill_timeout " + text_or_none(p.sigkill_timeout));
}

void describe(Text& out, const NetworkPlan& n) {
  if (!n.declared && !n.mode) return;
  out.line(0, std::string("network ") + (n.mode ? to_text(*n.mode) : "default") +
                  (n.domain_id ? " domain " + std::to_string(*n.domain_id) : "") + " interfaces [" +
                  join(n.interfaces) + "] peers [" + join(n.peers) + "]" + (n.allow_load ? ", allow_load" : "") +
                  (n.remote_control ? ", remote_control" : ""));
  if (n.security) {
    out.line(1, "security keystore '" + n.security->keystore + "' enclave '" + n.security->enclave + "' " +
                    (n.security->enforced ? "Enforce" : "Permissive"));
  }
  for (const auto& e : n.exports) {
    out.line(1, "export " + e.topic + " max_hz " + to_text(ParameterValue{e.max_hz}) + " max_bytes " +
                    std::to_string(e.max_bytes_per_s) + (e.compressed_only ? " compressed_only" : ""));
  }
}

}  // namespace

QoS ComponentPlan::qos_for(const std::string& topic, Side side, const QoS& in_code) const {
  for (const auto& entry : qos) {
    if (entry.topic == topic && entry.side == side) return entry.applied_to(in_code);
  }
  return in_code;
}

std::vector<std::string> ProgramPlan::command_arguments() const {
  std::vector<std::string> words = arguments;
  if (ros_arguments.empty()) return words;
  words.emplace_back("--ros-args");
  words.insert(words.end(), ros_arguments.begin(), ros_arguments.end());
  return words;
}

const ComponentPlan* Plan::find(std::string_view full_name) const {
  for (const auto& component : components) {
    if (component.full_name() == full_name) return &component;
  }
  return nullptr;
}

std::string to_text(const Plan& plan) {
  Text out;
  out.line(0, "container " + fully_qualified_node_name(plan.container.namespace_, plan.container.name));
  out.parameters(1, "param", plan.container.parameters);
  if (plan.name_space.moves())
    out.line(0, "namespace " + plan.name_space.path + ", apart by " + to_text(plan.name_space.tf));
  describe(out, plan.network);
  for (const auto& a : plan.arguments) {
    out.line(0, "argument " + a.name + (a.default_value ? " default " + *a.default_value : "") + " choices [" +
                    join(a.choices) + "] " + a.description);
  }
  for (const auto& c : plan.components) describe(out, c);
  for (const auto& p : plan.programs) describe(out, p);
  for (const auto& m : plan.messages) out.line(0, "message " + m.text);
  for (const auto& u : plan.unused_sections) out.line(0, "unused " + u.pattern);
  return out.all;
}

const char* to_text(When when) {
  switch (when) {
    case When::Active: return "active";
    case When::FirstMessage: return "first_message";
    case When::Tf: return "tf";
    case When::Service: return "service";
  }
  return "active";
}

const char* to_text(Side side) { return side == Side::Publisher ? "publisher" : "subscription"; }

const char* to_text(TargetState state) {
  switch (state) {
    case TargetState::Unconfigured: return "unconfigured";
    case TargetState::Inactive: return "inactive";
    case TargetState::Active: return "active";
  }
  return "active";
}

}  // namespace nacelle::launch
