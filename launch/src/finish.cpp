// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "builder.hpp"
#include "unsupported.hpp"

namespace nacelle::launch {

void Builder::check_names() {
  std::map<std::string, Place> seen;
  const auto claim = [&](const std::string& full_name, const Place& where) {
    const auto [first, added] = seen.emplace(full_name, where);
    if (!added)
      report(where, LaunchFault::Twice,
             "a second node has the name '" + full_name + "'; the first is at " + first->second.text(),
             "give it another name or namespace");
  };
  if (plan_.container.declared)
    claim(fully_qualified_node_name(plan_.container.namespace_, plan_.container.name), plan_.container.where);
  for (const auto& component : plan_.components) {
    if (!component.name.empty()) claim(component.full_name(), component.where);
  }
  for (const auto& program : plan_.programs) {
    if (!program.name.empty()) claim(fully_qualified_node_name(program.namespace_, program.name), program.where);
  }
}

void Builder::check_targets() {
  const ContainerPlan& container = plan_.container;
  for (const auto& target : targets_) {
    if (!container.declared) {
      report(target.where, LaunchFault::UnknownName,
             "there is no container '" + target.name + "': the files declare no node_container");
    } else if (target.name != container.name &&
               target.name != fully_qualified_node_name(container.namespace_, container.name)) {
      report(target.where, LaunchFault::UnknownName, "there is no container '" + target.name + "'",
             suggestion(target.name, {container.name}));
    }
  }
}

void Builder::resolve_after() {
  std::vector<std::string> full_names;
  for (const auto& component : plan_.components) full_names.push_back(component.full_name());
  const auto known = [&](const std::string& name) {
    return std::find(full_names.begin(), full_names.end(), name) != full_names.end();
  };
  for (auto& component : plan_.components) {
    for (auto& condition : component.after) {
      std::string full = join_namespaces(component.namespace_, condition.node);
      // A short name is first looked for beside the component, then at the root: of the launch, if it is in a namespace.
      const std::string at_root = join_namespaces("/", condition.node);
      for (const auto& other : {plan_.name_space.moves() ? plan_.name_space.path + at_root : at_root, at_root}) {
        if (!known(full) && known(other)) full = other;
      }
      if (!known(full)) {
        // One of that name in another namespace is what is meant; else what is near, as it would have to be written here.
        std::vector<std::string> elsewhere, others;
        for (const auto& other : plan_.components) {
          if (&other == &component) continue;
          const std::string other_full = other.full_name();
          const bool is_short =
              !condition.node.starts_with('/') && (other.namespace_ == component.namespace_ || other.namespace_ == "/");
          others.push_back(is_short ? other.name : other_full);
          if (other.name == condition.node) elsewhere.push_back("'" + other_full + "'");
        }
        report(condition.where, LaunchFault::UnknownName,
               "'after' names the node '" + condition.node.substr(0, 80) + "', which is not a component of this launch",
               elsewhere.empty() ? suggestion(condition.node.substr(0, 80), others)
                                 : "did you mean " + join(elsewhere, " or ") + "?");
      } else if (full == component.full_name()) {
        report(condition.where, LaunchFault::Circle, "the node '" + component.name + "' cannot wait for itself");
      }
      condition.node = std::move(full);
      resolve_detail(condition);
    }
  }
}

void Builder::resolve_detail(AfterCondition& condition) {
  const std::string word = to_text(condition.when);
  if (condition.when == When::Active) {
    if (!condition.detail.empty())
      report(condition.where, LaunchFault::WrongValue,
             "'active' takes nothing in parentheses, not '" + condition.detail.substr(0, 80) + "'");
    return;
  }
  if (condition.when == When::Tf) {
    const auto arrow = condition.detail.find("->");
    if (arrow == std::string::npos || arrow == 0 || arrow + 2 == condition.detail.size())
      return report(condition.where, LaunchFault::WrongValue,
                    "'tf' needs two frames, not '" + condition.detail.substr(0, 80) + "'", "write tf(odom->base_link)");
    condition.detail = plan_.name_space.frame(condition.detail.substr(0, arrow)) + "->" +
                       plan_.name_space.frame(condition.detail.substr(arrow + 2));
    return;
  }
  if (condition.detail.empty())
    return report(condition.where, LaunchFault::MissingKey, "'" + word + "' needs a name", "write " + word + "(/name)");
  // As in `qos`: the name after remapping, seen from the node that has it.
  const ComponentPlan* const node = plan_.find(condition.node);
  if (node == nullptr) return;  // that has been told
  auto full = expand_topic_name(condition.detail, node->name, node->namespace_);
  if (!full) return report(condition.where, full.error());
  condition.detail = std::move(full).value();
}

void Builder::find_cycles() {
  // Takes away what waits for nothing that is left, until nothing more can be taken; the rest waits in a circle.
  std::map<std::string, const ComponentPlan*> left;
  for (const auto& component : plan_.components) left.emplace(component.full_name(), &component);
  const auto waits = [&left](const ComponentPlan& component) {
    return std::any_of(component.after.begin(), component.after.end(),
                       [&](const auto& c) { return left.count(c.node) != 0; });
  };
  const auto take_what_can_go = [&] {
    for (bool taken = true; taken;) {
      taken = std::erase_if(left, [&](const auto& entry) { return !waits(*entry.second); }) > 0;
    }
  };
  // From any of the rest, following one wait each leads into a circle. What waits for that one is no circle of its own.
  for (take_what_can_go(); !left.empty(); take_what_can_go()) {
    std::vector<const ComponentPlan*> path{left.begin()->second};
    for (bool closed = false; !closed;) {
      const auto& after = path.back()->after;
      const auto next =
          std::find_if(after.begin(), after.end(), [&](const auto& c) { return left.count(c.node) != 0; });
      const ComponentPlan* waited_for = left.at(next->node);
      const auto seen = std::find(path.begin(), path.end(), waited_for);
      closed = seen != path.end();
      if (closed) {
        std::string text;
        for (auto step = seen; step != path.end(); ++step) text += (*step)->name + " waits for ";
        report(next->where, LaunchFault::Circle, "'after' forms a cycle: " + text + waited_for->name,
               "take one of the conditions out");
      }
      path.push_back(waited_for);
    }
    for (const ComponentPlan* component : path) left.erase(component->full_name());
  }
}

void Builder::check_arguments() {
  std::vector<std::string> known{declared_.begin(), declared_.end()};
  known.insert(known.end(), {kNetworkArgument, kNamespaceArgument, kTfArgument});
  for (const auto& [name, value] : arguments_) {
    if (declared_.count(name) != 0 || is_for_every_file(name)) continue;
    report({plan_.file, 0}, LaunchFault::UnknownName, "the files declare no argument '" + name.substr(0, 80) + "'",
           suggestion(name.substr(0, 80), known));
  }
}

Result<Plan, std::vector<Problem>> Builder::finish() {
  if (wanted_ == Wanted::Plan) {
    check_names();
    check_targets();
    resolve_after();
    if (problems_.empty()) find_cycles();
  }
  check_arguments();
  apply_network_argument();
  check_namespace();
  for (auto& refusal : refuse_unavailable(plan_)) problems_.push_back(coded(std::move(refusal), LaunchFault::Refused));
  for (const auto& [key, section] : sections_) {
    if (!section.second) plan_.unused_sections.push_back({key.second, section.first});
  }
  // Where a value is missing, what was found after it may be a consequence; the arguments themselves are known.
  const bool lists = wanted_ == Wanted::Arguments && lacks_argument_;
  if (problems_.empty() || lists) return std::move(plan_);
  // A file that is included twice tells its faults twice.
  std::vector<Problem> once;
  for (auto& problem : problems_) {
    if (once.size() < 200 && std::find(once.begin(), once.end(), problem) == once.end())
      once.push_back(std::move(problem));
  }
  return err(std::move(once));
}

}  // namespace nacelle::launch
