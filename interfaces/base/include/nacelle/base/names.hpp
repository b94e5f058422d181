// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {

// ROS 2's names of nodes, topics and services: what is allowed, what a relative name means, and remapping.
// Source: rcl (jazzy) validate_topic_name.c, expand_topic_name.c, arguments.c, remap.c; rmw validate_*.h.
// Everything here is pure. Threads: call from anywhere. Errors: a Problem whose `where` is empty; the caller knows it.

/// Longest names in bytes: a DDS topic name has 255, of which ROS 2 keeps 8 for its prefixes.
inline constexpr std::size_t kMaxTopicNameBytes = 247;
inline constexpr std::size_t kMaxNamespaceBytes = 245;
inline constexpr std::size_t kMaxNodeNameBytes = 255;

/// A node's name: letters, digits and '_', not empty, no digit in front.
[[nodiscard]] Result<void, Problem> validate_node_name(std::string_view name);
/// An absolute namespace: "/" or "/a/b".
[[nodiscard]] Result<void, Problem> validate_namespace(std::string_view name);
/// A topic's or service's name as a program writes it: "/abs", "rel/ative", "~/private", "{node}/x".
[[nodiscard]] Result<void, Problem> validate_topic_name(std::string_view name);
/// A topic's or service's name after expansion: "/a/b".
[[nodiscard]] Result<void, Problem> validate_full_topic_name(std::string_view name);

/// The fully qualified name of a topic or service that a node names.
///
/// "/x" stays, "x" becomes "<namespace>/x", "~/x" becomes "<namespace>/<node>/x"; {node}, {ns}, {namespace} stand for
/// the node's own. Remapping comes afterwards (remap_topic, remap_service).
[[nodiscard]] Result<std::string, Problem> expand_topic_name(std::string_view name, std::string_view node_name,
                                                             std::string_view node_namespace);

/// "/arm" and "camera" make "/arm/camera"; "/" and "camera" make "/camera".
[[nodiscard]] std::string fully_qualified_node_name(std::string_view node_namespace, std::string_view node_name);
/// An absolute `name` stays, a relative one is put below `prefix`; empty is `prefix`. Never ends with '/' but for "/".
[[nodiscard]] std::string join_namespaces(std::string_view prefix, std::string_view name);

/// What a remap rule changes.
enum class RemapKind : std::uint8_t {
  TopicOrService,  ///< from:=to
  Topic,           ///< rostopic://from:=to
  Service,         ///< rosservice://from:=to
  NodeName,        ///< __node:=name or __name:=name
  Namespace        ///< __ns:=/absolute
};

/// One rule; the names are as written, they are expanded with the node that they are applied to.
struct RemapRule {
  RemapKind kind = RemapKind::TopicOrService;
  std::string node;  ///< Applies to the node with this original name only; empty: to every node.
  std::string from;  ///< Empty for NodeName and Namespace.
  std::string to;
  friend bool operator==(const RemapRule&, const RemapRule&) = default;
};

/// Reads "from:=to" with the prefixes above. Wildcards and back references are refused, as rcl does.
[[nodiscard]] Result<RemapRule, Problem> parse_remap_rule(std::string_view text);
/// The same from the two halves of a launch file's `remap`.
[[nodiscard]] Result<RemapRule, Problem> make_remap_rule(std::string_view from, std::string_view to);
/// The rule as one would write it: "front:rostopic://image:=left/image".
[[nodiscard]] std::string to_text(const RemapRule& rule);

/// Whom rules are applied for.
struct RemapContext {
  std::string_view node_name;       ///< After remapping.
  std::string_view node_namespace;  ///< After remapping.
  std::string_view original_name;   ///< What a rule's node prefix is compared with; empty: the same as node_name.
};

/// The name after the first rule that matches; without one, the name itself. There is no chaining.
/// `full_name` is an expanded name; put a node's own rules before global ones.
[[nodiscard]] Result<std::string, Problem> remap_topic(std::string_view full_name, const std::vector<RemapRule>& rules,
                                                       const RemapContext& context);
[[nodiscard]] Result<std::string, Problem> remap_service(std::string_view full_name,
                                                         const std::vector<RemapRule>& rules,
                                                         const RemapContext& context);
/// A node's name or namespace after the first rule that matches.
[[nodiscard]] std::string remap_node_name(std::string_view name, const std::vector<RemapRule>& rules);
[[nodiscard]] std::string remap_namespace(std::string_view node_namespace, std::string_view node_name,
                                          const std::vector<RemapRule>& rules);

}  // namespace nacelle
