// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/names.hpp"

#include <cstddef>
#include <utility>

#include "nacelle/base/name_fault.hpp"

namespace nacelle {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_'; }

// Names come from files and from the network: a control character must not reach a terminal.
std::string in_quotes(std::string_view name) {
  std::string out = "'";
  for (const char c : name.substr(0, 80)) out += (c >= ' ' && c < 0x7f) ? c : '?';
  if (name.size() > 80) out += "...";
  return out + "'";
}

Problem bad(std::string_view kind, std::string_view name, std::string why) {
  return {"", "the " + std::string(kind) + " " + in_quotes(name) + " " + std::move(why), "", NameFault::Invalid,
          std::string(name)};
}

Problem too_long(std::string_view kind, std::string_view name, std::size_t limit) {
  return bad(kind, name,
             "has " + std::to_string(name.size()) + " bytes; at most " + std::to_string(limit) + " are allowed");
}

Result<void, Problem> validate_absolute(std::string_view kind, std::string_view name, std::size_t limit) {
  if (name.empty()) return err(Problem{"", "the " + std::string(kind) + " is empty", "", NameFault::Invalid});
  if (name.front() != '/') return err(bad(kind, name, "is not absolute: it must start with '/'"));
  if (name.back() == '/') return err(bad(kind, name, "must not end with '/'"));
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (c != '/' && !is_word(c)) return err(bad(kind, name, "may hold only letters, digits, '_' and '/'"));
    if (c != '/') continue;
    if (name[i + 1] == '/') return err(bad(kind, name, "must not hold '//'"));
    if (is_digit(name[i + 1])) return err(bad(kind, name, "has a part that starts with a digit"));
  }
  if (name.size() > limit) return err(too_long(kind, name, limit));
  return {};
}

constexpr std::string_view kTopic = "topic or service name";

// The end of the substitution that starts at `open`, or a fault.
Result<std::size_t, Problem> validate_substitution(std::string_view name, std::size_t open) {
  const auto close = name.find('}', open);
  if (close == std::string_view::npos) return err(bad(kTopic, name, "has a '{' without its '}'"));
  const auto word = name.substr(open + 1, close - open - 1);
  if (word != "node" && word != "ns" && word != "namespace") {
    Problem problem = bad(kTopic, name, "holds the unknown substitution {" + in_quotes(word) + "}");
    problem.way_out = suggestion(word, {"node", "ns", "namespace"});
    return err(std::move(problem));
  }
  return close;
}

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
}

Result<std::string, Problem> remap(std::string_view full_name, const std::vector<RemapRule>& rules, RemapKind kind,
                                   const RemapContext& context) {
  const auto original = context.original_name.empty() ? context.node_name : context.original_name;
  for (const auto& rule : rules) {
    if (rule.kind != RemapKind::TopicOrService && rule.kind != kind) continue;
    if (!rule.node.empty() && rule.node != original) continue;
    const auto from = expand_topic_name(rule.from, context.node_name, context.node_namespace);
    if (!from) return err(from.error());
    if (*from != full_name) continue;
    return expand_topic_name(rule.to, context.node_name, context.node_namespace);
  }
  return std::string(full_name);
}

}  // namespace

Result<void, Problem> validate_node_name(std::string_view name) {
  constexpr std::string_view kKind = "node name";
  if (name.empty()) return err(Problem{"", "the node name is empty", ""});
  for (const char c : name) {
    if (!is_word(c)) return err(bad(kKind, name, "may hold only letters, digits and '_'"));
  }
  if (is_digit(name.front())) return err(bad(kKind, name, "must not start with a digit"));
  if (name.size() > kMaxNodeNameBytes) return err(too_long(kKind, name, kMaxNodeNameBytes));
  return {};
}

Result<void, Problem> validate_namespace(std::string_view name) {
  if (name == "/") return {};
  return validate_absolute("namespace", name, kMaxNamespaceBytes);
}

Result<void, Problem> validate_full_topic_name(std::string_view name) {
  return validate_absolute(kTopic, name, kMaxTopicNameBytes);
}

Result<void, Problem> validate_topic_name(std::string_view name) {
  if (name.empty()) return err(Problem{"", "the topic or service name is empty", ""});
  if (name.back() == '/') return err(bad(kTopic, name, "must not end with '/'"));
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (c == '{') {
      const auto close = validate_substitution(name, i);
      if (!close) return err(close.error());
      i = *close;
    } else if (c == '~') {
      if (i != 0) return err(bad(kTopic, name, "may hold '~' only as its first character"));
      if (name.size() > 1 && name[1] != '/') return err(bad(kTopic, name, "needs a '/' after '~'"));
    } else if (c != '/' && !is_word(c)) {
      return err(
          bad(kTopic, name, "may hold only letters, digits, '_', '/', a leading '~' and {node}, {ns}, {namespace}"));
    } else if (is_digit(c) && (i == 0 || name[i - 1] == '/')) {
      return err(bad(kTopic, name, "has a part that starts with a digit"));
    }
  }
  return {};
}

Result<std::string, Problem> expand_topic_name(std::string_view name, std::string_view node_name,
                                               std::string_view node_namespace) {
  if (auto ok = validate_topic_name(name); !ok) return err(ok.error());
  if (auto ok = validate_node_name(node_name); !ok) return err(ok.error());
  if (auto ok = validate_namespace(node_namespace); !ok) return err(ok.error());
  std::string full(name);
  if (full.front() == '~') full = fully_qualified_node_name(node_namespace, node_name) + full.substr(1);
  replace_all(full, "{node}", node_name);
  replace_all(full, "{ns}", node_namespace);
  replace_all(full, "{namespace}", node_namespace);
  if (full.front() != '/') full = (node_namespace == "/" ? "/" : std::string(node_namespace) + "/") + full;
  if (auto ok = validate_full_topic_name(full); !ok) return err(ok.error());
  return full;
}

std::string fully_qualified_node_name(std::string_view node_namespace, std::string_view node_name) {
  std::string full(node_namespace);
  if (full.empty() || full.front() != '/') full.insert(full.begin(), '/');
  if (full.back() != '/') full += '/';
  return full + std::string(node_name);
}

std::string join_namespaces(std::string_view prefix, std::string_view name) {
  std::string full;
  if (!name.empty() && name.front() == '/') {
    full = name;
  } else {
    full = prefix;
    if (full.empty() || full.front() != '/') full.insert(full.begin(), '/');
    if (!name.empty()) full += (full.back() == '/' ? "" : "/") + std::string(name);
  }
  while (full.size() > 1 && full.back() == '/') full.pop_back();
  return full;
}

Result<RemapRule, Problem> parse_remap_rule(std::string_view text) {
  const auto split = text.find(":=");
  if (split == std::string_view::npos) {
    return err(Problem{"", "the remap rule " + in_quotes(text) + " has no ':='", "write from:=to"});
  }
  return make_remap_rule(text.substr(0, split), text.substr(split + 2));
}

Result<RemapRule, Problem> make_remap_rule(std::string_view from, std::string_view to) {
  RemapRule rule;
  if (const auto colon = from.find(':'); colon != std::string_view::npos && from.substr(colon, 3) != "://") {
    rule.node = from.substr(0, colon);
    if (auto ok = validate_node_name(rule.node); !ok) return err(ok.error());
    from.remove_prefix(colon + 1);
  }
  constexpr std::string_view kTopicScheme = "rostopic://", kServiceScheme = "rosservice://";
  if (from.starts_with(kTopicScheme)) {
    rule.kind = RemapKind::Topic;
    from.remove_prefix(kTopicScheme.size());
  } else if (from.starts_with(kServiceScheme)) {
    rule.kind = RemapKind::Service;
    from.remove_prefix(kServiceScheme.size());
  } else if (from == "__node" || from == "__name") {
    rule.kind = RemapKind::NodeName;
  } else if (from == "__ns") {
    rule.kind = RemapKind::Namespace;
  }
  rule.to = to;
  if (rule.kind == RemapKind::NodeName || rule.kind == RemapKind::Namespace) {
    const auto ok = rule.kind == RemapKind::NodeName ? validate_node_name(to) : validate_namespace(to);
    if (!ok) return err(ok.error());
    return rule;
  }
  rule.from = from;
  for (const auto name : {from, to}) {
    if (name.find_first_of("*\\") != std::string_view::npos) {
      return err(Problem{"", "the remap rule " + in_quotes(to_text(rule)) + " has a wildcard or a back reference",
                         "ROS 2 does not know them either; write one rule per name"});
    }
    if (auto ok = validate_topic_name(name); !ok) return err(ok.error());
  }
  return rule;
}

std::string to_text(const RemapRule& rule) {
  std::string text = rule.node.empty() ? "" : rule.node + ":";
  switch (rule.kind) {
    case RemapKind::TopicOrService: text += rule.from; break;
    case RemapKind::Topic: text += "rostopic://" + rule.from; break;
    case RemapKind::Service: text += "rosservice://" + rule.from; break;
    case RemapKind::NodeName: text += "__node"; break;
    case RemapKind::Namespace: text += "__ns"; break;
  }
  return text + ":=" + rule.to;
}

Result<std::string, Problem> remap_topic(std::string_view full_name, const std::vector<RemapRule>& rules,
                                         const RemapContext& context) {
  return remap(full_name, rules, RemapKind::Topic, context);
}

Result<std::string, Problem> remap_service(std::string_view full_name, const std::vector<RemapRule>& rules,
                                           const RemapContext& context) {
  return remap(full_name, rules, RemapKind::Service, context);
}

std::string remap_node_name(std::string_view name, const std::vector<RemapRule>& rules) {
  for (const auto& rule : rules) {
    if (rule.kind == RemapKind::NodeName && (rule.node.empty() || rule.node == name)) return rule.to;
  }
  return std::string(name);
}

std::string remap_namespace(std::string_view node_namespace, std::string_view node_name,
                            const std::vector<RemapRule>& rules) {
  for (const auto& rule : rules) {
    if (rule.kind == RemapKind::Namespace && (rule.node.empty() || rule.node == node_name)) return rule.to;
  }
  return std::string(node_namespace);
}

}  // namespace nacelle
