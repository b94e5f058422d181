// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <ranges>

#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"

namespace nacelle::lifecycle_manager {
namespace {

enum class Mark { New, Open, Done };

// Depth-first along `after`; an open node met again closes a cycle.
struct Sorter {
  const std::vector<ManagedNode>& nodes;
  std::vector<Mark> marks = std::vector<Mark>(nodes.size(), Mark::New);
  std::vector<std::size_t> order;
  std::vector<std::string> path;

  [[nodiscard]] std::ptrdiff_t index_of(const std::string& name) const {
    const auto found = std::ranges::find(nodes, name, &ManagedNode::name);
    return found == nodes.end() ? -1 : found - nodes.begin();
  }

  Result<void, Problem> visit(std::size_t i) {
    if (marks[i] == Mark::Done) return {};
    if (marks[i] == Mark::Open) {
      std::vector<std::string> cycle(std::ranges::find(path, nodes[i].name), path.end());
      cycle.push_back(nodes[i].name);
      return err(Problem{nodes[i].after.front().where, "these nodes wait for each other: " + join(cycle, " -> "),
                         "remove one of their after: entries", LifecycleFault::OrderCircle, nodes[i].name});
    }
    marks[i] = Mark::Open;
    path.push_back(nodes[i].name);
    for (const auto& dependency : nodes[i].after) {
      const auto j = index_of(dependency.node);
      if (j < 0) {
        std::vector<std::string> names;
        for (const auto& node : nodes) names.push_back(node.name);
        return err(Problem{dependency.where,
                           nodes[i].name + " is after '" + dependency.node + "', which is not in the plan",
                           suggestion(dependency.node, names), NameFault::Unknown, dependency.node});
      }
      if (auto ok = visit(static_cast<std::size_t>(j)); !ok) return ok;
    }
    path.pop_back();
    marks[i] = Mark::Done;
    order.push_back(i);
    return {};
  }
};

}  // namespace

Result<std::vector<ManagedNode>, Problem> bring_up_order(std::vector<ManagedNode> nodes) {
  Sorter sorter{nodes};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (auto ok = sorter.visit(i); !ok) return err(ok.error());
  }
  std::vector<ManagedNode> ordered;
  ordered.reserve(nodes.size());
  for (const std::size_t i : sorter.order) ordered.push_back(std::move(nodes[i]));
  return ordered;
}

}  // namespace nacelle::lifecycle_manager
