// SPDX-License-Identifier: Apache-2.0
// Rules about what flows between components: types, quality of service, names, limits.
#include <algorithm>

#include "nacelle/host/standard_interfaces.hpp"
#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

/// Returns the line of `qos:` that set this endpoint's QoS; otherwise the component's line.
Place place_of_end(const launch::Plan& plan, const std::string& node, const std::string& topic, launch::Side side) {
  const launch::ComponentPlan* const component = plan.find(node);
  if (component == nullptr) return node;
  for (const auto& entry : component->qos) {
    if (entry.topic == topic && entry.side == side) return entry.where;
  }
  return component->where;
}

/// A set_remap that fits no node of all that it stands above.
void check_shared_remaps(Evidence& evidence) {
  for (const auto& shared : evidence.plan.shared_remaps) {
    const auto uses = [&](const LoadedComponent& component) {
      const launch::ComponentPlan& plan = *component.plan;
      if (!component.declared) return true;  // unknown
      for (std::size_t i = 0; i < plan.shared_remaps && i < component.declared->used_remaps.size(); ++i) {
        if (component.declared->used_remaps[i] && plan.remap_lines[i] == shared.where) return true;
      }
      return false;
    };
    const auto gets = [&](const launch::ProgramPlan& program) {  // the names of a program's topics are unknown
      return std::ranges::find(program.ros_arguments, to_text(shared.rule)) != program.ros_arguments.end();
    };
    if (std::ranges::any_of(evidence.loaded, uses) || std::ranges::any_of(evidence.plan.programs, gets)) continue;
    std::vector<std::string> names;
    std::vector<std::string> nodes;
    for (const auto& component : evidence.loaded) {
      nodes.push_back(component.plan->name);
      const loading::TopicEnds ends = evidence.ends_of(component);
      for (const auto* const some : {&ends.published, &ends.subscribed, &ends.services})
        names.insert(names.end(), some->begin(), some->end());
    }
    std::ranges::sort(names);
    names.erase(std::unique(names.begin(), names.end()), names.end());
    const std::string& from = shared.rule.from;
    const bool of_nobody = !shared.rule.node.empty() && std::ranges::find(nodes, shared.rule.node) == nodes.end();
    // The names are absolute, and the rule is read in each node's namespace: near ones only, no list.
    const std::string near = nearest_name(from.starts_with('/') ? from : "/" + from, names);
    evidence.find(
        Rule::UnusedRemap,
        {shared.where,
         of_nobody
             ? "the set_remap of '" + from + "' is for a node '" + shared.rule.node + "', which is not there"
             : "no node has a topic or service '" + from + "': remapping it to '" + shared.rule.to + "' has no effect",
         of_nobody      ? suggestion(shared.rule.node, nodes)
         : near.empty() ? "put it before the nodes that it applies to, in their group or file"
                        : "did you mean '" + near + "'?"});
  }
}

}  // namespace

void check_pairs(Evidence& evidence) {
  for (const auto& clash : evidence.container.clashes()) {
    const auto place_of = [&](const std::string& node, launch::Side side) {
      return place_of_end(evidence.plan, node, clash.topic, side);
    };
    const std::string writer_place = place_of(clash.writer_node, launch::Side::Publisher).text();
    evidence.find(clash.policy == "type" ? Rule::TopicTypes : Rule::QosMismatch,
                  {place_of(clash.reader_node, launch::Side::Subscription),
                   clash.topic + ": " + clash.what(writer_place), clash.change},
                  severity_of(evidence.plan, {clash.writer_node, clash.reader_node}));
  }
}

void check_topics(Evidence& evidence) {
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared) continue;
    const loading::TopicEnds ends = evidence.ends_of(component);
    const Severity severity = severity_of(*component.plan);
    for (auto& problem : loading::unused_qos(*component.plan, ends))
      evidence.find(Rule::UnusedQos, std::move(problem), severity);
    const launch::ComponentPlan& plan = *component.plan;
    for (auto& unused : loading::unused_remaps(plan.remaps, component.declared->used_remaps, plan.full_name(), ends)) {
      if (unused.rule < plan.shared_remaps) continue;  // fits one node of several
      const bool has_line = unused.rule < plan.remap_lines.size();
      evidence.find(Rule::UnusedRemap,
                    {has_line ? plan.remap_lines[unused.rule] : plan.where, std::move(unused.problem.what),
                     std::move(unused.problem.way_out)},
                    severity);
    }
  }
  check_shared_remaps(evidence);
}

std::vector<runtime::StreamBudget> stream_budgets(const launch::Plan& plan, const runtime::Container& container) {
  std::vector<runtime::StreamBudget> budgets;
  for (const auto& component : plan.components) {
    for (const auto& budget : component.budgets) {
      std::vector<std::string> topics{budget.topic};
      if (budget.topic.empty()) topics = container.topics_of(component.full_name());
      std::erase_if(topics, [&](const std::string& topic) { return budget.topic.empty() && is_standard_topic(topic); });
      for (const auto& topic : topics)
        budgets.push_back({budget.where, topic, budget.max_copies, budget.max_age, budget.min_hz});
    }
  }
  return budgets;
}

Severity severity_of_budget(const launch::Plan& plan, const Place& where) {
  for (const auto& component : plan.components) {
    for (const auto& budget : component.budgets) {
      if (budget.where == where) return severity_of(component);
    }
  }
  return Severity::Error;
}

void check_budgets(Evidence& evidence) {
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared) continue;
    const loading::TopicEnds ends = evidence.ends_of(component);
    for (const auto& budget : component.plan->budgets) {
      if (budget.topic.empty() || ends.published.count(budget.topic) != 0 || ends.subscribed.count(budget.topic) != 0)
        continue;
      std::vector<std::string> topics{ends.published.begin(), ends.published.end()};
      topics.insert(topics.end(), ends.subscribed.begin(), ends.subscribed.end());
      evidence.find(Rule::UnusedBudget,
                    {budget.where,
                     component.plan->full_name() + " has no topic '" + budget.topic + "': this budget limits nothing",
                     suggestion(budget.topic, topics)},
                    severity_of(*component.plan));
    }
  }
  const runtime::BudgetWatch watch{stream_budgets(evidence.plan, evidence.container)};
  for (auto& problem : watch.check_wiring(evidence.container)) {
    const Severity severity = severity_of_budget(evidence.plan, problem.where);
    evidence.find(Rule::Budget, std::move(problem), severity);
  }
}

}  // namespace nacelle::proof
