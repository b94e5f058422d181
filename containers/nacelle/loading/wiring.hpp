// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::loading {

/// Full names of a component's topics and of the services that it offers.
struct TopicEnds {
  std::set<std::string> published, subscribed, services{};
};

/// Finds a component's topics as the difference of the graph before and after its load. Endpoints are declared in the
/// constructor of the component.
/// Threads: the one that loads.
class GraphBefore {
 public:
  explicit GraphBefore(const runtime::Container& container);
  [[nodiscard]] TopicEnds added() const;

 private:
  using Counts = std::map<std::pair<std::string, std::string>, std::pair<std::size_t, std::size_t>>;
  [[nodiscard]] Counts count() const;

  const runtime::Container& container_;
  const Counts before_;
};

/// Returns the launch file's settings for topics that the component does not have, each with file and line. Pure.
[[nodiscard]] std::vector<Problem> unused_qos(const launch::ComponentPlan& plan, const TopicEnds& ends);
/// A remap rule that changed no name; `where` of the problem is the rule's text.
struct UnusedRemap {
  std::size_t rule = 0;  ///< Index in the list of rules.
  Problem problem;
};
/// Returns the rules that are not marked in `used` (runtime::Declarations::used_remaps). Pure.
[[nodiscard]] std::vector<UnusedRemap> unused_remaps(const std::vector<RemapRule>& rules, const std::vector<bool>& used,
                                                     const std::string& node, const TopicEnds& ends);

}  // namespace nacelle::loading
