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

std::vector<std::string> unused_qos(const launch::ComponentPlan& plan, const TopicEnds& ends) {
  std::vector<std::string> lines;
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
    lines.push_back(problem.text());
  }
  return lines;
}

std::vector<std::string> unused_remaps(const std::vector<RemapRule>& rules, const std::string& node,
                                       const TopicEnds& ends) {
  const std::size_t slash = node.rfind('/');
  const std::string name = node.substr(slash + 1), name_space = slash == 0 ? "/" : node.substr(0, slash);
  const auto topics = all_of(ends);
  std::vector<std::string> lines;
  for (const auto& rule : rules) {
    if (rule.kind != RemapKind::TopicOrService && rule.kind != RemapKind::Topic) continue;
    const auto to = expand_topic_name(rule.to, name, name_space);
    if (to && std::find(topics.begin(), topics.end(), *to) != topics.end()) continue;
    const auto from = expand_topic_name(rule.from, name, name_space);
    std::string way_out = suggestion(from ? *from : rule.from, topics);
    // A service's name cannot be looked up: whoever says that it is one hears nothing.
    if (rule.kind == RemapKind::TopicOrService)
      way_out += (way_out.empty() ? "" : " ") + ("a service's is written rosservice://" + rule.from + ":=" + rule.to);
    lines.push_back(Problem{"-r " + to_text(rule), node + " has no topic '" + rule.from + "'", way_out}.text());
  }
  return lines;
}

}  // namespace nacelle::session
