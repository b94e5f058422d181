// SPDX-License-Identifier: Apache-2.0
// Rules about transforms: every frame has one parent, and all of them hang together.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <unordered_map>

#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

using runtime::ClaimedFrame;

Place place_of_claim(const launch::Plan& plan, const ClaimedFrame& claim) {
  const launch::ComponentPlan* const component = plan.find(claim.node);
  if (component == nullptr) return claim.node;
  if (!claim.origin.parameter.empty()) return place_of_parameter(*component, claim.origin.parameter);
  // A joint of the description stands in the file that a parameter names.
  return place_of_parameter(*component, "robot_description_file");
}

std::string namespace_of(const std::string& node) { return node.substr(0, node.rfind('/')); }

/// A part of the forest: frames that transforms join.
struct Tree {
  std::set<std::string> frames, namespaces;
  std::vector<const ClaimedFrame*> claims;
};

/// Sets that are joined, by the number of a member (union by halving of paths).
class Joined {
 public:
  std::size_t number_of(const std::string& frame) {
    const auto [found, is_new] = numbers_.emplace(frame, above_.size());
    if (is_new) above_.push_back(found->second);
    return found->second;
  }
  std::size_t top_of(std::size_t number) {
    while (above_[number] != number) number = above_[number] = above_[above_[number]];
    return number;
  }
  void join(std::size_t a, std::size_t b) { above_[top_of(a)] = top_of(b); }

 private:
  std::unordered_map<std::string, std::size_t> numbers_;
  std::vector<std::size_t> above_;
};

/// In the order of their first claims.
std::vector<Tree> trees_of(const std::vector<ClaimedFrame>& claims) {
  Joined joined;
  for (const ClaimedFrame& claim : claims) joined.join(joined.number_of(claim.parent), joined.number_of(claim.child));
  std::vector<Tree> trees;
  std::unordered_map<std::size_t, std::size_t> tree_of_top;
  for (const ClaimedFrame& claim : claims) {
    const auto top = joined.top_of(joined.number_of(claim.child));
    const auto [found, is_new] = tree_of_top.emplace(top, trees.size());
    if (is_new) trees.emplace_back();
    Tree& tree = trees[found->second];
    tree.frames.insert({claim.parent, claim.child});
    tree.namespaces.insert(namespace_of(claim.node));
    tree.claims.push_back(&claim);
  }
  return trees;
}

std::string first_of(const Tree& tree) {
  const ClaimedFrame& claim = *tree.claims.front();
  return "'" + claim.parent + "' -> '" + claim.child + "' (" + claim.node +
         (claim.origin.empty() ? "" : ", " + claim.origin.text()) + ")";
}

/// The pair of names that are most alike, as a question.
std::string likely_slip(const Tree& small, const Tree& large) {
  const std::vector<std::string> names{large.frames.begin(), large.frames.end()};
  for (const auto& frame : small.frames) {
    if (const auto near = nearest_name(frame, names); !near.empty())
      return fmt::format("did you mean '{}' where '{}' is written?", near, frame);
  }
  return "name a frame of the other one as parent or child, or broadcast a transform between them";
}

void check_tree(const std::vector<ClaimedFrame>& claims, Evidence& evidence) {
  std::vector<Tree> trees = trees_of(claims);
  std::ranges::stable_sort(trees, [](const Tree& a, const Tree& b) { return a.frames.size() > b.frames.size(); });
  for (std::size_t i = 1; i < trees.size(); ++i) {
    // Robots in namespaces of their own have trees of their own.
    std::vector<std::string> shared;
    std::ranges::set_intersection(trees[0].namespaces, trees[i].namespaces, std::back_inserter(shared));
    if (shared.empty()) continue;
    evidence.find(Rule::FrameTrees, {place_of_claim(evidence.plan, *trees[i].claims.front()),
                                     "the frames are not one tree: " + first_of(trees[i]) +
                                         " does not meet the tree of " + first_of(trees[0]),
                                     likely_slip(trees[i], trees[0])});
  }
}

void check_circles(const std::vector<ClaimedFrame>& claims, Evidence& evidence) {
  std::map<std::string, const ClaimedFrame*> above;
  for (const auto& claim : claims) above.emplace(claim.child, &claim);
  std::set<std::string> done;
  for (const auto& [frame, claim] : above) {
    std::vector<std::string> path;
    std::set<std::string> on_path;
    std::string at = frame;
    while (above.count(at) != 0 && done.count(at) == 0 && on_path.insert(at).second) {
      path.push_back(at);
      at = above.at(at)->parent;
    }
    const auto begin = std::ranges::find(path, at);
    if (begin != path.end()) {
      std::string text = "'" + at + "'";
      for (auto step = begin; step != path.end(); ++step) text += " is below '" + above.at(*step)->parent + "'";
      const ClaimedFrame& last = *above.at(at);
      evidence.find(Rule::FrameCircle,
                    {place_of_claim(evidence.plan, last), "frames form a cycle: " + text,
                     "change " + (last.origin.empty() ? last.node : last.origin.text() + " of " + last.node)});
    }
    done.insert(path.begin(), path.end());
  }
}

/// The frame above which nothing is broadcast.
std::string root_above(const std::string& frame, const std::vector<ClaimedFrame>& claims) {
  std::string at = frame;
  for (std::size_t steps = 0; steps < claims.size(); ++steps) {  // a circle ends, too
    const auto above = std::ranges::find(claims, at, &ClaimedFrame::child);
    if (above == claims.end()) return at;
    at = above->parent;
  }
  return frame;
}

/// A filter that moves base_link where the description hangs it below base_footprint: the filter has to move base_footprint.
/// Empty: the conflict is another one.
std::string way_out_by_root(const std::string& child, const std::vector<ClaimedFrame>& claims,
                            const Evidence& evidence) {
  static constexpr std::array<std::string_view, 4> kAboveAnyRobot{"map", "odom", "world", "earth"};  // REP 105
  const auto claim_of = [&](bool fixed) {
    return std::ranges::find_if(claims, [&](const ClaimedFrame& claim) {
      return claim.child == child && (claim.kind == FrameClaimKind::Fixed) == fixed;
    });
  };
  const auto fixed = claim_of(true), moving = claim_of(false);
  if (fixed == claims.end() || moving == claims.end()) return {};
  const std::string root = root_above(fixed->parent, claims);
  if (root == child || root == moving->parent || std::ranges::find(kAboveAnyRobot, root) != kAboveAnyRobot.end())
    return {};
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared || component.plan->full_name() != moving->node) continue;
    const auto& uses = component.declared->frame_uses;
    const auto use = std::ranges::find(uses, child, &FrameUse::frame);
    if (use != uses.end())
      return fmt::format("write {}: {} for {}, the root of the robot's own frames", use->parameter, root, moving->node);
  }
  return {};
}

}  // namespace

void check_frames(Evidence& evidence) {
  const std::vector<ClaimedFrame> claims = evidence.container.frames();
  if (claims.empty()) return;  // the plan broadcasts no frames: another program does
  std::map<std::string, std::vector<const ClaimedFrame*>> by_child;
  for (const auto& claim : claims) by_child[claim.child].push_back(&claim);
  for (auto& conflict : evidence.container.frame_conflicts()) {
    Place where = conflict.where;
    for (const ClaimedFrame* const claim : by_child[conflict.value]) {
      where = place_of_claim(evidence.plan, *claim);
      // A joint's line is not known, so the other claim's place is more useful.
      if (claim->kind != FrameClaimKind::Fixed) break;
    }
    if (auto way_out = way_out_by_root(conflict.value, claims, evidence); !way_out.empty())
      conflict.way_out = std::move(way_out);
    evidence.find(Rule::FrameOwners, {where, conflict.where.text() + " " + conflict.what, conflict.way_out});
  }
  check_circles(claims, evidence);
  check_tree(claims, evidence);
  std::set<std::string> frames;
  for (const auto& claim : claims) frames.insert({claim.parent, claim.child});
  // Without a description the plan is probably a part of a robot, so this is only a warning.
  const bool described =
      std::ranges::any_of(claims, [](const ClaimedFrame& claim) { return claim.kind == FrameClaimKind::Fixed; });
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared) continue;
    for (const FrameUse& use : component.declared->frame_uses) {
      if (use.frame.empty() || frames.count(use.frame) != 0) continue;
      evidence.find(Rule::NoFrame,
                    {place_of_parameter(*component.plan, use.parameter),
                     component.plan->full_name() + ": parameter '" + use.parameter + "' names the frame '" + use.frame +
                         "', which no component broadcasts",
                     suggestion(use.frame, {frames.begin(), frames.end()})},
                    described ? Severity::Error : Severity::Warning);
    }
  }
}

}  // namespace nacelle::proof
