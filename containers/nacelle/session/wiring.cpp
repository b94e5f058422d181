// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/wiring.hpp"

#include <algorithm>

namespace nacelle::session {
namespace {

std::vector<std::string> all_of(const TopicEnds& ends) {
  std::set<std::string> all = ends.published;
  all.insert(ends.subscribed.begin(), ends.subscribed.end());
  return {all.begin(), all.end()};
}

}  // namespace

GraphBefore::GraphBefore(const runtime::Container& container) : container_(container), before_(count()) {}

GraphBefore::Counts GraphBefore::count() const {
  std::vector<runtime::StreamReport> streams;
  container_.report_streams(streams);
  Counts counts;
  for (const auto& stream : streams) counts[{stream.name, stream.type}] = {stream.writers, stream.readers};
  return counts;
}

TopicEnds GraphBefore::added() const {
  TopicEnds ends;
  for (const auto& [key, now] : count()) {
    const auto found = before_.find(key);
    const auto [writers, readers] = found == before_.end() ? std::pair<std::size_t, std::size_t>{} : found->second;
    if (now.first > writers) ends.published.insert(key.first);
    if (now.second > readers) ends.subscribed.insert(key.first);
  }
  return ends;
}

std::vector<Problem> unused_qos(const launch::ComponentPlan& plan, const TopicEnds& ends) {
  std::vector<Problem> problems;
  for (const auto& entry : plan.qos) {
    const bool publisher = entry.side == launch::Side::Publisher;
    const auto& mine = publisher ? ends.published : ends.subscribed;
    const auto& others = publisher ? ends.subscribed : ends.published;
    if (mine.count(entry.topic) != 0) continue;
    Problem problem{entry.where.text(), "", ""};
    if (others.count(entry.topic) != 0) {
      problem.what = plan.full_name() + (publisher ? " does not publish '" : " does not subscribe to '") + entry.topic +
                     "': this quality of service has no effect";
      problem.way_out = publisher ? "write 'subscription'" : "write 'publisher'";
    } else {
      problem.what = plan.full_name() + " has no topic '" + entry.topic + "': this quality of service has no effect";
      problem.way_out = suggestion(entry.topic, all_of(ends));
    }
    problems.push_back(std::move(problem));
  }
  return problems;
}

namespace {
/// A rule for an action is written for its name, and changes those of all of its parts.
void add_actions(std::vector<std::string>& names) {
  for (std::size_t i = 0, n = names.size(); i < n; ++i) {
    const auto part = names[i].find("/_action/");
    if (part != std::string::npos) names.push_back(names[i].substr(0, part));
  }
}
}  // namespace

std::vector<Problem> unused_remaps(const std::vector<RemapRule>& rules, const std::string& node,
                                   const TopicEnds& ends) {
  const std::size_t slash = node.rfind('/');
  const std::string name = node.substr(slash + 1), name_space = slash == 0 ? "/" : node.substr(0, slash);
  std::vector<Problem> problems;
  for (const auto& rule : rules) {
    if (rule.kind == RemapKind::NodeName || rule.kind == RemapKind::Namespace) continue;
    if (!rule.node.empty() && rule.node != name) continue;
    std::vector<std::string> names;
    if (rule.kind != RemapKind::Service) names = all_of(ends);
    if (rule.kind != RemapKind::Topic) names.insert(names.end(), ends.services.begin(), ends.services.end());
    if (rule.kind != RemapKind::Topic) add_actions(names);
    const auto to = expand_topic_name(rule.to, name, name_space);
    if (to && std::find(names.begin(), names.end(), *to) != names.end()) continue;
    const auto from = expand_topic_name(rule.from, name, name_space);
    const char* const kind = rule.kind == RemapKind::Service ? "service"
                             : rule.kind == RemapKind::Topic ? "topic"
                                                             : "topic or service";
    problems.push_back(
        {"-r " + to_text(rule),
         node + " has no " + kind + " '" + rule.from + "': remapping it to '" + rule.to + "' has no effect",
         suggestion(from ? *from : rule.from, names)});
  }
  return problems;
}

}  // namespace nacelle::session
