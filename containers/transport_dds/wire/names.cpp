// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/names.hpp"

#include <algorithm>
#include <initializer_list>

#include "nacelle/base/names.hpp"

namespace nacelle::transport_dds {
namespace {

struct Affix {
  WireKind kind;
  std::string_view prefix, suffix;
};
constexpr Affix kTopic{WireKind::Topic, "rt", ""};
constexpr Affix kRequest{WireKind::Request, "rq", "Request"};
constexpr Affix kReply{WireKind::Reply, "rr", "Reply"};

constexpr std::string_view kTypeScope = "dds_::";

Result<std::string, Problem> mangled(const Affix& affix, std::string_view name, bool avoid_ros_conventions) {
  if (avoid_ros_conventions) {
    if (name.empty()) return err(Problem{"", "the topic or service name is empty", ""});
  } else if (auto valid = validate_full_topic_name(name); !valid) {
    return err(valid.error());
  }
  std::string dds(avoid_ros_conventions ? "" : affix.prefix);
  dds.append(name).append(affix.suffix);
  if (dds.size() > kMaxDdsNameBytes) {
    return err(Problem{"",
                       "the DDS name of '" + std::string(name.substr(0, 80)) + "...' has " +
                           std::to_string(dds.size()) + " bytes; at most " + std::to_string(kMaxDdsNameBytes) +
                           " are allowed",
                       "shorten the name or its namespace"});
  }
  return dds;
}

std::optional<std::string> without(const Affix& affix, std::string_view dds) {
  if (dds.size() > kMaxDdsNameBytes || !dds.starts_with(affix.prefix) || !dds.ends_with(affix.suffix))
    return std::nullopt;
  dds.remove_prefix(affix.prefix.size());
  if (dds.size() < affix.suffix.size()) return std::nullopt;
  dds.remove_suffix(affix.suffix.size());
  if (!validate_full_topic_name(dds)) return std::nullopt;
  return std::string(dds);
}

// An identifier of .msg files and of C++.
bool is_identifier(std::string_view word) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !word.empty() && !is_digit(word.front()) &&
         std::all_of(word.begin(), word.end(), [&](char c) { return is_letter(c) || is_digit(c); });
}

}  // namespace

Result<std::string, Problem> dds_topic_name(std::string_view name, bool avoid_ros_conventions) {
  return mangled(kTopic, name, avoid_ros_conventions);
}
Result<std::string, Problem> dds_request_name(std::string_view service, bool avoid_ros_conventions) {
  return mangled(kRequest, service, avoid_ros_conventions);
}
Result<std::string, Problem> dds_reply_name(std::string_view service, bool avoid_ros_conventions) {
  return mangled(kReply, service, avoid_ros_conventions);
}

RosName ros_name(std::string_view dds_topic) {
  if (dds_topic == kDiscoveryTopic) return {WireKind::Discovery, {}};
  for (const Affix& affix : {kTopic, kRequest, kReply}) {
    if (auto name = without(affix, dds_topic)) return {affix.kind, std::move(*name)};
  }
  return {};
}

Result<std::string, Problem> dds_type_name(std::string_view ros_type) {
  std::string dds;
  std::string_view rest = ros_type;
  for (auto slash = rest.find('/'); slash != std::string_view::npos; slash = rest.find('/')) {
    dds.append(rest.substr(0, slash)).append("::");
    rest.remove_prefix(slash + 1);
  }
  dds.append(kTypeScope).append(rest).append("_");
  if (dds.size() > kMaxDdsNameBytes || ros_type_name(dds) != ros_type) {
    return err(Problem{"", "'" + std::string(ros_type.substr(0, 80)) + "' is not the name of a type",
                       "such as std_msgs/msg/String"});
  }
  return dds;
}

std::optional<std::string> ros_type_name(std::string_view dds_type) {
  const auto scope = dds_type.find(kTypeScope);
  if (dds_type.size() > kMaxDdsNameBytes || scope == std::string_view::npos || !dds_type.ends_with('_'))
    return std::nullopt;
  std::string name;
  for (std::string_view spaces = dds_type.substr(0, scope); !spaces.empty();) {
    const auto colons = spaces.find("::");
    if (colons == std::string_view::npos || !is_identifier(spaces.substr(0, colons))) return std::nullopt;
    name.append(spaces.substr(0, colons)).append("/");
    spaces.remove_prefix(colons + 2);
  }
  std::string_view word = dds_type.substr(scope + kTypeScope.size());
  if (word.empty()) return std::nullopt;
  word.remove_suffix(1);
  if (!is_identifier(word)) return std::nullopt;
  return name.append(word);
}

std::optional<std::string> service_of_half(std::string_view ros_type) {
  for (const std::string_view suffix : {"_Request", "_Response"}) {
    if (ros_type.size() <= suffix.size() || !ros_type.ends_with(suffix)) continue;
    return std::string(ros_type.substr(0, ros_type.size() - suffix.size()));
  }
  return std::nullopt;
}

std::string service_event_topic(std::string_view service) { return std::string(service) += "/_service_event"; }

}  // namespace nacelle::transport_dds
