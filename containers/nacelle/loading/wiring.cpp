// SPDX-License-Identifier: Apache-2.0
#include "loading/wiring.hpp"

#include <algorithm>

namespace nacelle::loading {
namespace {

std::vector<std::string> all_of(const TopicEnds& ends) {
  std::set<std::string> all = ends.published;
  all.insert(ends.subscribed.begin(), ends.subscribed.end());
  return {all.begin(), all.end()};
}

/// A rule for an action is written for its name, and changes those of all of its parts.
void add_actions(std::vector<std::string>& names) {
  for (std::size_t i = 0, n = names.size(); i < n; ++i) {
    const auto part = names[i].find("/_action/");
    if (part != std::string::npos) names.push_back(names[i].substr(0, part));
  }
}

Problem why_unused(const RemapRule& rule, const std::string& node, const TopicEnds& ends) {
  const std::size_t slash = node.rfind('/');
  const std::string name = node.substr(slash + 1), name_space = slash == 0 ? "/" : node.substr(0, slash);
  if (!rule.node.empty() && rule.node != name) {
    return {"-r " + to_text(rule), "the rule is for a node '" + rule.node + "', and this one is '" + name + "'",
            suggestion(rule.node, {name})};
  }
  std::vector<std::string> names;
  if (rule.kind != RemapKind::Service) names = all_of(ends);
  if (rule.kind != RemapKind::Topic) names.insert(names.end(), ends.services.begin(), ends.services.end());
  if (rule.kind != RemapKind::Topic) add_actions(names);
  const auto from = expand_topic_name(rule.from, name, name_space), to = expand_topic_name(rule.to, name, name_space);
  const bool is_there = from && std::find(names.begin(), names.end(), *from) != names.end();
  if (from && to && *from == *to && is_there)
    return {"-r " + to_text(rule), "'" + rule.from + "' is remapped to itself", "leave the rule out"};
  // A name that the node has anyway is no better one.
  std::erase_if(names, [&](const auto& other) { return to && other == *to; });
  const char* const kind = rule.kind == RemapKind::Service ? "service"
                           : rule.kind == RemapKind::Topic ? "topic"
                                                           : "topic or service";
  return {"-r " + to_text(rule),
          node + " has no " + kind + " '" + rule.from + "': remapping it to '" + rule.to + "' has no effect",
          suggestion(from ? *from : rule.from, names)};
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
    Problem problem{entry.where, "", ""};
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

std::vector<UnusedRemap> unused_remaps(const std::vector<RemapRule>& rules, const std::vector<bool>& used,
                                       const std::string& node, const TopicEnds& ends) {
  std::vector<UnusedRemap> unused;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const bool renames_node = rules[i].kind == RemapKind::NodeName || rules[i].kind == RemapKind::Namespace;
    if (renames_node || (i < used.size() && used[i])) continue;
    const auto before = std::find_if(rules.begin(), rules.begin() + static_cast<std::ptrdiff_t>(i),
                                     [&](const RemapRule& other) { return other.from == rules[i].from; });
    const auto first = static_cast<std::size_t>(before - rules.begin());
    if (first < i && first < used.size() && used[first]) {
      unused.push_back({i,
                        {"-r " + to_text(rules[i]),
                         node + " remaps '" + rules[i].from + "' twice: the first rule wins, to '" + before->to + "'",
                         "leave one of them out"}});
    } else {
      unused.push_back({i, why_unused(rules[i], node, ends)});
    }
  }
  return unused;
}

}  // namespace nacelle::loading
