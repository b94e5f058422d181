// SPDX-License-Identifier: Apache-2.0
// Rules about waiting: everything that a component waits for must be provided by one that does not wait in turn.
#include <algorithm>
#include <map>
#include <set>

#include "nacelle/host/standard_interfaces.hpp"
#include "nacelle/spatial/transform_buffer.hpp"
#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

using launch::AfterCondition;
using launch::ComponentPlan;
using launch::When;

bool holds(const std::vector<std::string>& all, const std::string& name) {
  return std::ranges::find(all, name) != all.end();
}

/// One thing that has to be there before a component is activated.
struct Wait {
  const ComponentPlan* waiter = nullptr;
  const AfterCondition* condition = nullptr;
  std::string what;              ///< "a message on '/scan'"
  std::string gives;             ///< How the others provide it: "publishes"; empty: by being active.
  std::set<std::string> givers;  ///< Nodes; any of them is enough.
};

class Order {
 public:
  explicit Order(Evidence& evidence) : evidence_(evidence) {
    for (const auto& endpoint : evidence.endpoints) {
      if (!endpoint.publishes) continue;
      publishers_[endpoint.topic].insert(endpoint.node);
      // Topics that every node has would hide the intended one.
      if (!is_standard_topic(endpoint.topic)) topics_.push_back(endpoint.topic);
    }
    topics_.erase(std::unique(topics_.begin(), topics_.end()), topics_.end());  // they come by topic
    for (const auto& component : evidence.loaded) {
      if (!component.declared) {
        free_.insert(component.plan->full_name());  // the reason why it could not be made is reported already
        continue;
      }
      for (const auto& service : component.declared->services) {
        servers_[service].insert(component.plan->full_name());
        services_.push_back(service);
      }
      for (const auto& service : standard_services_of(evidence, component))
        servers_[service].insert(component.plan->full_name());
      const auto found = evidence.container.find(component.plan->full_name());
      if (found && !found.value().managed) free_.insert(component.plan->full_name());  // it runs once it is made
    }
    for (const auto& claim : evidence.container.frames()) {
      // A fallback does not broadcast if another node does.
      auto& link = links_[claim.child];
      const bool fallback = claim.kind == FrameClaimKind::Fallback;
      if (link.givers.empty() || (link.fallback && !fallback)) link = {claim.parent, {}, fallback};
      if (link.fallback == fallback) link.givers.insert(claim.node);
      frames_.insert(frames_.end(), {claim.parent, claim.child});
    }
  }

  void check() {
    for (const auto& component : evidence_.plan.components) {
      for (const auto& condition : component.after) read(component, condition);
    }
    while (const Wait* const stuck = first_stuck()) tell_circle(*stuck);
  }

 private:
  struct Link {  // of a frame to the one above it
    std::string parent;
    std::set<std::string> givers;
    bool fallback = false;
  };

  void cannot(const ComponentPlan& waiter, const AfterCondition& condition, const std::string& what,
              const std::string& why, std::string way_out) {
    evidence_.find(Rule::NeverMet,
                   {condition.where, waiter.full_name() + " waits for " + what + ", " + why, std::move(way_out)},
                   severity_of(evidence_.plan, {waiter.full_name(), condition.node}));
  }

  [[nodiscard]] bool is_free(const std::string& node) const {
    return free_.count(node) != 0 || evidence_.plan.find(node) == nullptr;
  }
  [[nodiscard]] bool never_active(const std::string& node) const {
    return !is_free(node) && evidence_.plan.find(node)->target != launch::TargetState::Active;
  }

  void read(const ComponentPlan& waiter, const AfterCondition& condition) {
    if (!take({&waiter, &condition, condition.node, "", {condition.node}})) return;
    const std::string& name = condition.detail;
    switch (condition.when) {
      case When::Active: return;
      case When::FirstMessage: {
        const std::string what = "a message on '" + name + "'";
        if (!name.empty() && publishers_.count(name) == 0)
          return cannot(waiter, condition, what, "which no component publishes", suggestion(name, topics_));
        static_cast<void>(take({&waiter, &condition, what, "publishes", publishers_[name]}));
        return;
      }
      case When::Service: {
        const std::string what = "the service '" + name + "'";
        if (!name.empty() && servers_.count(name) == 0)
          return cannot(waiter, condition, what, "which no component offers", suggestion(name, services_));
        static_cast<void>(take({&waiter, &condition, what, "offers", servers_[name]}));
        return;
      }
      case When::Tf: return read_transform(waiter, condition);
    }
  }

  void read_transform(const ComponentPlan& waiter, const AfterCondition& condition) {
    const auto arrow = condition.detail.find("->");
    if (arrow == std::string::npos) return;
    const std::string what = "the transform " + condition.detail;
    if (!evidence_.container.shared_object(spatial::kTransformBufferName))
      return cannot(waiter, condition, what, "and no component collects transforms",
                    "load nacelle::transforms::TransformsComponent");
    if (frames_.empty()) return;  // the plan broadcasts no frames: another program does
    const std::string ends[]{condition.detail.substr(0, arrow), condition.detail.substr(arrow + 2)};
    bool known = true;
    for (const auto& frame : ends) {
      if (holds(frames_, frame)) continue;
      cannot(waiter, condition, what, "and no component broadcasts the frame '" + frame + "'",
             suggestion(frame, frames_));
      known = false;
    }
    if (!known) return;
    const auto up = path_up(ends[0]), also = path_up(ends[1]);
    if (up.back() != also.back())
      return cannot(waiter, condition, what, "and nothing joins the two frames",
                    "broadcast a transform between '" + up.back() + "' and '" + also.back() + "'");
    for (const auto* const path : {&up, &also}) {
      for (const auto& frame : *path) {
        if (links_.count(frame) == 0 || holds(path == &up ? also : up, frame)) continue;  // above where they meet
        if (!take({&waiter, &condition, what, "broadcasts '" + frame + "'", links_[frame].givers})) return;
      }
    }
  }

  /// From the frame to the root of its tree; stops at a cycle, which is reported elsewhere.
  [[nodiscard]] std::vector<std::string> path_up(const std::string& frame) const {
    std::vector<std::string> path{frame};
    for (auto link = links_.find(frame); link != links_.end(); link = links_.find(path.back())) {
      if (holds(path, link->second.parent)) break;
      path.push_back(link->second.parent);
    }
    return path;
  }

  /// Returns false, and reports it, if the nodes that could provide it will not be active.
  bool take(Wait wait) {
    if (std::ranges::all_of(wait.givers, [&](const auto& node) { return never_active(node); }) &&
        !wait.givers.empty()) {
      const std::string& giver = *wait.givers.begin();
      const char* const state = to_text(evidence_.plan.find(giver)->target);
      cannot(*wait.waiter, *wait.condition, wait.what,
             wait.gives.empty() ? "which `autostart` leaves " + std::string{state}
                                : "which only " + giver + " " + wait.gives + ", and `autostart` leaves it " + state,
             wait.gives.empty() ? "write autostart: active there, or leave the condition out"
                                : "write autostart: active for " + giver + ", or leave the condition out");
      return false;
    }
    waits_.push_back(std::move(wait));
    return true;
  }

  [[nodiscard]] bool is_met(const Wait& wait) const {
    return wait.givers.empty() || std::ranges::any_of(wait.givers, [&](const auto& node) { return is_free(node); });
  }

  /// Frees components that wait only for free ones, until no more can be freed. Returns the first wait that is stuck;
  /// null: all components are free.
  const Wait* first_stuck() {
    for (bool freed = true; freed;) {
      freed = false;
      for (const auto& component : evidence_.plan.components) {
        const std::string name = component.full_name();
        if (is_free(name) || never_active(name)) continue;
        const bool waits =
            std::ranges::any_of(waits_, [&](const Wait& wait) { return wait.waiter == &component && !is_met(wait); });
        if (waits) continue;
        free_.insert(name);
        freed = true;
      }
    }
    const auto stuck = std::ranges::find_if(waits_, [&](const Wait& wait) {
      return !is_free(wait.waiter->full_name()) && !never_active(wait.waiter->full_name()) && !is_met(wait);
    });
    return stuck == waits_.end() ? nullptr : &*stuck;
  }

  [[nodiscard]] const Wait* wait_of(const std::string& node) const {
    const auto found = std::ranges::find_if(
        waits_, [&](const Wait& wait) { return wait.waiter->full_name() == node && !is_met(wait); });
    return found == waits_.end() ? nullptr : &*found;
  }

  /// From any stuck component, following one wait each leads into a cycle.
  void tell_circle(const Wait& from) {
    std::vector<const Wait*> path{&from};
    auto begin = path.end();
    while (begin == path.end()) {
      const Wait& last = *path.back();
      const auto giver =
          std::ranges::find_if(last.givers, [&](const auto& node) { return !is_free(node) && !never_active(node); });
      const Wait* const next = giver == last.givers.end() ? nullptr : wait_of(*giver);
      if (next == nullptr) break;  // cannot happen: a component that is not free waits
      begin = std::ranges::find(path, next->waiter, &Wait::waiter);
      if (begin == path.end()) {
        path.push_back(next);
        begin = path.end();
      }
    }
    std::string text;
    bool optional = false;
    for (auto step = begin; step != path.end(); ++step) {
      const Wait& wait = **step;
      if (!text.empty()) text += ", and ";
      text += wait.waiter->full_name() + " waits for " + wait.what;
      if (!wait.gives.empty())
        text += ", which only " + join({wait.givers.begin(), wait.givers.end()}, " and ") + " " + wait.gives;
      optional = optional || !wait.waiter->required;
      free_.insert(wait.waiter->full_name());
    }
    if (text.empty()) return static_cast<void>(free_.insert(from.waiter->full_name()));
    evidence_.find(
        Rule::OrderCircle,
        {(*begin)->condition->where, text + ": these conditions can never be met", "take one of the conditions out"},
        optional ? Severity::Warning : Severity::Error);
  }

  Evidence& evidence_;
  std::map<std::string, std::set<std::string>> publishers_, servers_;
  std::map<std::string, Link> links_;  // by child
  std::vector<std::string> topics_, services_, frames_;
  std::vector<Wait> waits_;
  std::set<std::string> free_;  // nodes that will be active in any case, or for which it is unknown
};

}  // namespace

void check_order(Evidence& evidence) { Order{evidence}.check(); }

}  // namespace nacelle::proof
