// SPDX-License-Identifier: Apache-2.0
#include "replay/cast.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>

#include "nacelle/base/name_fault.hpp"

namespace nacelle::replay {
namespace {

bool share_one(const std::set<std::string>& a, const std::set<std::string>& b) {
  return std::ranges::any_of(a, [&](const std::string& topic) { return b.contains(topic); });
}

std::string last_name(const Candidate& candidate) { return candidate.node.substr(candidate.node.rfind('/') + 1); }

bool is_called(const Candidate& candidate, const std::string& name) {
  return candidate.node == name || last_name(candidate) == name;
}

Problem unknown(const std::vector<Candidate>& candidates, const std::string& name) {
  std::vector<std::string> names;
  names.reserve(candidates.size());
  for (const auto& candidate : candidates)
    names.push_back(name.starts_with('/') ? candidate.node : last_name(candidate));
  return {"--nodes", "the launch file has no component '" + name + "'", suggestion(name, names), NameFault::Unknown,
          name};
}

Result<void, Problem> leave_out_unnamed(const std::vector<Candidate>& candidates, const std::vector<std::string>& named,
                                        std::vector<Role>& roles) {
  for (auto& role : roles) role.left_out = "it is not named";
  for (const auto& name : named) {
    bool is_known = false;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& candidate = candidates[i];
      if (!is_called(candidate, name)) continue;
      is_known = true;
      if (!candidate.driver.empty())
        return err(Problem{"--nodes", candidate.node + " is a driver: " + candidate.driver,
                           "a replay opens no device; what it publishes is played if it was recorded",
                           NameFault::Invalid, name});
      roles[i].left_out = candidate.failure;
    }
    if (!is_known) return err(unknown(candidates, name));
  }
  return {};
}

/// Leaves out, one after the other, what has nothing to read.
void leave_out_unfed(const std::vector<Candidate>& candidates, const std::set<std::string>& recorded,
                     std::vector<Role>& roles) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!roles[i].runs() || share_one(candidates[i].reads, recorded)) continue;
      bool is_fed = false;
      for (std::size_t j = 0; j < candidates.size(); ++j)
        is_fed = is_fed || (j != i && roles[j].runs() && share_one(candidates[i].reads, candidates[j].publishes));
      if (is_fed) continue;
      roles[i].left_out = "it reads nothing that was recorded";
      changed = true;
    }
  }
}

}  // namespace

Result<std::vector<Role>, Problem> cast(const std::vector<Candidate>& candidates, const std::set<std::string>& recorded,
                                        const std::vector<std::string>& named) {
  std::vector<Role> roles;
  for (const auto& candidate : candidates) roles.push_back({candidate.node, ""});
  if (!named.empty()) {
    if (auto done = leave_out_unnamed(candidates, named, roles); !done) return err(done.error());
    return roles;
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& candidate = candidates[i];
    roles[i].left_out = !candidate.failure.empty() ? candidate.failure
                        : candidate.driver.empty() ? ""
                                                   : "driver: " + candidate.driver;
  }
  leave_out_unfed(candidates, recorded, roles);
  return roles;
}

std::vector<MissingTopic> missing_topics(const std::vector<Candidate>& candidates, const std::vector<Role>& roles,
                                         const std::set<std::string>& recorded) {
  std::set<std::string> known = recorded;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (roles[i].runs()) known.insert(candidates[i].publishes.begin(), candidates[i].publishes.end());
  }
  std::map<std::string, MissingTopic> missing;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!roles[i].runs()) continue;
    for (const auto& topic : candidates[i].reads) {
      if (known.contains(topic)) continue;
      MissingTopic& one = missing[topic];
      one.topic = topic;
      one.readers.push_back(candidates[i].node);
    }
  }
  std::vector<MissingTopic> all;
  for (auto& [topic, one] : missing) {
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!roles[i].runs() && one.publisher.empty() && candidates[i].publishes.contains(topic))
        one.publisher = candidates[i].node;
    }
    all.push_back(std::move(one));
  }
  return all;
}

std::vector<std::string> without_transforms(const std::vector<Candidate>& candidates, const std::vector<Role>& roles) {
  std::vector<std::string> users;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!roles[i].runs()) continue;
    if (candidates[i].reads.contains("/tf_static")) return {};
    if (candidates[i].uses_frames) users.push_back(candidates[i].node);
  }
  return users;
}

}  // namespace nacelle::replay
