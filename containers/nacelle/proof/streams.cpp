// SPDX-License-Identifier: Apache-2.0
// Rules about what flows between components: types, quality of service, names, limits, conditions.
#include <algorithm>

#include "nacelle/base/names.hpp"
#include "nacelle/proof/rules.hpp"

namespace nacelle::proof {
namespace {

/// The line of `qos:` that made this end what it is; else the component's.
std::string place_of_end(const launch::Plan& plan, const std::string& node, const std::string& topic,
                         launch::Side side) {
  const launch::ComponentPlan* const component = plan.find(node);
  if (component == nullptr) return node;
  for (const auto& entry : component->qos) {
    if (entry.topic == topic && entry.side == side) return entry.where.text();
  }
  return component->where.text();
}

}  // namespace

void check_pairs(Evidence& evidence) {
  for (const auto& clash : evidence.container.clashes()) {
    const bool type = clash.policy == "type";
    const std::string writer = clash.topic + ": " + clash.writer_node + " (" +
                               place_of_end(evidence.plan, clash.writer_node, clash.topic, launch::Side::Publisher) +
                               ") publishes ";
    std::string what = type ? writer + clash.offered + ", " + clash.reader_node + " reads " + clash.requested
                            : writer + "with " + clash.policy + " " + clash.offered + ", " + clash.reader_node +
                                  " asks for " + clash.requested + ": it gets nothing from it";
    if (clash.other_writers != 0)
      what += ", though " + std::to_string(clash.other_writers) + " other publisher(s) serve it";
    evidence.find(type ? About::Type : About::Qos,
                  {place_of_end(evidence.plan, clash.reader_node, clash.topic, launch::Side::Subscription),
                   std::move(what), clash.change});
  }
}

void check_topics(Evidence& evidence) {
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared) continue;
    const session::TopicEnds ends = evidence.ends_of(component);
    const Severity severity = severity_of(*component.plan);
    for (auto& problem : session::unused_qos(*component.plan, ends))
      evidence.find(About::Qos, std::move(problem), severity);
    const auto& remaps = component.plan->remaps;
    const auto& lines = component.plan->remap_lines;
    for (std::size_t i = 0; i < remaps.size() && i < lines.size(); ++i) {
      if (lines[i].file.empty()) continue;  // a set_remap: it fits one node of several
      for (auto& problem : session::unused_remaps({remaps[i]}, component.plan->full_name(), ends))
        evidence.find(About::Remap, {lines[i].text(), std::move(problem.what), std::move(problem.way_out)}, severity);
    }
  }
}

std::vector<runtime::StreamBudget> stream_budgets(const launch::Plan& plan, const runtime::Container& container) {
  std::vector<runtime::StreamBudget> budgets;
  for (const auto& component : plan.components) {
    for (const auto& budget : component.budgets) {
      std::vector<std::string> topics{budget.topic};
      if (budget.topic.empty()) topics = container.topics_of(component.full_name());
      for (const auto& topic : topics)
        budgets.push_back({budget.where.text(), topic, budget.max_copies, budget.max_age, budget.min_hz});
    }
  }
  return budgets;
}

void check_budgets(Evidence& evidence) {
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared) continue;
    const session::TopicEnds ends = evidence.ends_of(component);
    for (const auto& budget : component.plan->budgets) {
      if (budget.topic.empty() || ends.published.count(budget.topic) != 0 || ends.subscribed.count(budget.topic) != 0)
        continue;
      std::vector<std::string> topics{ends.published.begin(), ends.published.end()};
      topics.insert(topics.end(), ends.subscribed.begin(), ends.subscribed.end());
      evidence.find(About::Budget,
                    {budget.where.text(),
                     component.plan->full_name() + " has no topic '" + budget.topic + "': this budget limits nothing",
                     suggestion(budget.topic, topics)});
    }
  }
  const runtime::BudgetWatch watch{stream_budgets(evidence.plan, evidence.container)};
  for (auto& problem : watch.check_wiring(evidence.container)) evidence.find(About::Budget, std::move(problem));
}

void check_order(Evidence& evidence) {
  std::vector<std::string> topics, services, frames;
  for (const auto& endpoint : evidence.endpoints) {
    // Everybody's transition_event would hide the topic that is meant.
    if (endpoint.publishes && !endpoint.topic.ends_with("/transition_event")) topics.push_back(endpoint.topic);
  }
  std::ranges::sort(topics);
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  for (const auto& component : evidence.loaded) {
    if (!component.declared) continue;
    services.insert(services.end(), component.declared->services.begin(), component.declared->services.end());
  }
  for (const auto& frame : evidence.container.frames()) frames.insert(frames.end(), {frame.parent, frame.child});
  const auto holds = [](const std::vector<std::string>& all, const std::string& name) {
    return std::ranges::find(all, name) != all.end();
  };
  for (const auto& component : evidence.plan.components) {
    for (const auto& after : component.after) {
      const auto cannot = [&](const std::string& waits_for, const std::string& why, std::string way_out) {
        evidence.find(About::Order, {after.where.text(), component.full_name() + " waits for " + waits_for + ", " + why,
                                     std::move(way_out)});
      };
      if (after.when == launch::When::FirstMessage || after.when == launch::When::Service) {
        if (after.detail.empty()) continue;
        const auto& all = after.when == launch::When::Service ? services : topics;
        // As the waiting component would write it, or as the one that is waited for.
        const launch::ComponentPlan* const other = evidence.plan.find(after.node);
        const auto own = expand_topic_name(after.detail, component.name, component.namespace_);
        const auto others = other == nullptr ? own : expand_topic_name(after.detail, other->name, other->namespace_);
        if ((own && holds(all, *own)) || (others && holds(all, *others))) continue;
        const bool service = after.when == launch::When::Service;
        cannot((service ? "the service '" : "a message on '") + after.detail + "'",
               service ? "which nobody offers" : "which nobody publishes", suggestion(own ? *own : after.detail, all));
      }
      if (after.when == launch::When::Tf && !frames.empty()) {
        const auto arrow = after.detail.find("->");
        if (arrow == std::string::npos) continue;
        for (const auto& frame : {after.detail.substr(0, arrow), after.detail.substr(arrow + 2)}) {
          if (!holds(frames, frame))
            cannot("the transform " + after.detail, "and nobody broadcasts the frame '" + frame + "'",
                   suggestion(frame, frames));
        }
      }
    }
  }
}

}  // namespace nacelle::proof
