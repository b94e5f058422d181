// SPDX-License-Identifier: Apache-2.0
// Parameters of nodes outside, by the services that each ROS 2 node has for them.
#include <limits>
#include <map>
#include <utility>

#include "nacelle/control/client.hpp"
#include "nacelle/remote/remote_nodes.hpp"
#include "nacelle/session/parameter_verbs.hpp"

namespace nacelle::remote {
namespace {

using control::reply_of;
using nlohmann::json;

// Of each of the questions that make an answer.
constexpr Duration kAnswer = 3s;
constexpr const char* kFields[] = {"",
                                   "bool_value",
                                   "integer_value",
                                   "double_value",
                                   "string_value",
                                   "byte_array_value",
                                   "bool_array_value",
                                   "integer_array_value",
                                   "double_array_value",
                                   "string_array_value"};

/// A number of msgs::to_json(), which has no other way to say these.
double double_of(const json& value) {
  if (value == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (value == "Infinity") return std::numeric_limits<double>::infinity();
  if (value == "-Infinity") return -std::numeric_limits<double>::infinity();
  return value.get<double>();
}

std::vector<double> doubles_of(const json& values) {
  std::vector<double> all;
  for (const auto& value : values) all.push_back(double_of(value));
  return all;
}

ParameterType type_of(const json& message) {
  const int type = message["type"].get<int>();
  return type < 0 || type > 9 ? ParameterType::NotSet : static_cast<ParameterType>(type);
}

/// Of rcl_interfaces/msg/ParameterValue.
ParameterValue value_of(const json& message) {
  const ParameterType type = type_of(message);
  const json& value = type == ParameterType::NotSet ? json{} : message[kFields[static_cast<std::size_t>(type)]];
  switch (type) {
    case ParameterType::NotSet: return {};
    case ParameterType::Bool: return value.get<bool>();
    case ParameterType::Integer: return value.get<std::int64_t>();
    case ParameterType::Double: return double_of(value);
    case ParameterType::String: return value.get<std::string>();
    case ParameterType::ByteArray: return value.get<std::vector<std::uint8_t>>();
    case ParameterType::BoolArray: return value.get<std::vector<bool>>();
    case ParameterType::IntegerArray: return value.get<std::vector<std::int64_t>>();
    case ParameterType::DoubleArray: return doubles_of(value);
    case ParameterType::StringArray: return value.get<std::vector<std::string>>();
  }
  return {};
}

ParameterDescriptor descriptor_of(const json& message) {
  ParameterDescriptor about;
  about.description = message["description"].get<std::string>();
  about.additional_constraints = message["additional_constraints"].get<std::string>();
  about.read_only = message["read_only"].get<bool>();
  about.dynamic_typing = message["dynamic_typing"].get<bool>();
  for (const auto& range : message["integer_range"])
    about.integer_range = {range["from_value"].get<std::int64_t>(), range["to_value"].get<std::int64_t>(),
                           range["step"].get<std::uint64_t>()};
  for (const auto& range : message["floating_point_range"])
    about.floating_point_range = {double_of(range["from_value"]), double_of(range["to_value"]),
                                  double_of(range["step"])};
  return about;
}

/// What a node's service of that name answers.
Result<json, Problem> ask(RemoteNetwork& network, const std::string& node, const char* service, const char* type,
                          const json& request) {
  return network.call(node + "/" + service, type, request, kAnswer);
}

/// The parameters' values, in the order of their names. rclcpp answers a question that names one without a value with
/// nothing at all, so these are left out of it.
Result<std::vector<ParameterValue>, Problem> values_of(RemoteNetwork& network, const std::string& node,
                                                       const json& names) {
  const Problem changed{node, "its parameters changed while they were read", "try again"};
  const auto typed =
      ask(network, node, "get_parameter_types", "rcl_interfaces/srv/GetParameterTypes", {{"names", names}});
  if (!typed) return err(typed.error());
  const json& types = typed.value()["types"];
  if (types.size() != names.size()) return err(changed);
  json with_value = json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (types[i] != 0) with_value.push_back(names[i]);
  }
  const auto got = ask(network, node, "get_parameters", "rcl_interfaces/srv/GetParameters", {{"names", with_value}});
  if (!got) return err(got.error());
  const json& values = got.value()["values"];
  if (values.size() != with_value.size()) return err(changed);
  std::vector<ParameterValue> all;
  for (std::size_t i = 0, next = 0; i < names.size(); ++i)
    all.push_back(types[i] == 0 ? ParameterValue{} : value_of(values[next++]));
  return all;
}

json list(RemoteNetwork& network, const std::string& node) {
  // They find their servers at the same time.
  for (const auto& [service, type] : {std::pair{"/describe_parameters", "rcl_interfaces/srv/DescribeParameters"},
                                      std::pair{"/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes"},
                                      std::pair{"/get_parameters", "rcl_interfaces/srv/GetParameters"}})
    static_cast<void>(network.prepare(node + service, type));
  const auto listed = ask(network, node, "list_parameters", "rcl_interfaces/srv/ListParameters", json::object());
  if (!listed) return reply_of(listed.error());
  const json names = listed.value()["result"]["names"];
  const auto described =
      ask(network, node, "describe_parameters", "rcl_interfaces/srv/DescribeParameters", {{"names", names}});
  if (!described) return reply_of(described.error());
  const auto values = values_of(network, node, names);
  if (!values) return reply_of(values.error());
  const json& descriptors = described.value()["descriptors"];
  if (descriptors.size() != names.size())
    return reply_of({node, "its parameters changed while they were read", "try again"});
  std::map<std::string, json> rows;  // in the order of their names
  for (std::size_t i = 0; i < names.size(); ++i) {
    runtime::ParameterReport row;
    row.name = names[i].get<std::string>();
    row.value = values.value()[i];
    row.type = type_of(descriptors[i]);
    row.descriptor = descriptor_of(descriptors[i]);
    json made = session::json_of(row);
    made.erase("given");  // which nobody tells
    rows.emplace(row.name, std::move(made));
  }
  json all = json::array();
  for (auto& [name, row] : rows) all.push_back(std::move(row));
  return {{"ok", true}, {"node", node}, {"parameters", all}};
}

/// {"name", "refusal"} of each, in their order.
Result<json, Problem> set(RemoteNetwork& network, const std::string& node, const std::vector<Parameter>& parameters) {
  json messages = json::array();
  for (const Parameter& parameter : parameters)
    messages.push_back({{"name", parameter.get_name()}, {"value", parameter_message(parameter.get_parameter_value())}});
  const auto answer =
      ask(network, node, "set_parameters", "rcl_interfaces/srv/SetParameters", {{"parameters", messages}});
  if (!answer) return err(answer.error());
  const json& results = answer.value()["results"];
  if (results.size() != parameters.size())
    return err(Problem{
        node,
        "answered for " + std::to_string(results.size()) + " of " + std::to_string(parameters.size()) + " parameters",
        ""});
  json rows = json::array();
  for (std::size_t i = 0; i < results.size(); ++i) {
    std::string refusal = results[i]["successful"].get<bool>() ? "" : results[i]["reason"].get<std::string>();
    if (!results[i]["successful"].get<bool>() && refusal.empty()) refusal = "the node refuses it and gives no reason";
    rows.push_back({{"name", parameters[i].get_name()}, {"refusal", std::move(refusal)}});
  }
  return rows;
}

json set_one(RemoteNetwork& network, const std::string& node, const Parameter& parameter) {
  const auto rows = set(network, node, {parameter});
  if (!rows) return reply_of(rows.error());
  const json& row = rows.value().front();
  if (const auto refusal = row["refusal"].get<std::string>(); !refusal.empty())
    return reply_of({node + ", parameter " + parameter.get_name(), refusal, ""});
  return {{"ok", true}, {"node", node}, {"name", parameter.get_name()}};
}

json set_many(RemoteNetwork& network, const std::string& node, const json& assignments) {
  std::vector<Parameter> parameters;
  for (const auto& text : assignments) {
    auto parameter = session::parameter_of_assignment(text.get<std::string>());
    if (!parameter) return reply_of(parameter.error());
    parameters.push_back(std::move(parameter).value());
  }
  const auto rows = set(network, node, parameters);
  if (!rows) return reply_of(rows.error());
  return {{"ok", true}, {"node", node}, {"results", rows.value()}};
}

}  // namespace

json parameter_message(const ParameterValue& value) {
  json message{{"type", static_cast<int>(nacelle::type_of(value))}};
  if (nacelle::type_of(value) != ParameterType::NotSet) message[kFields[value.index()]] = session::json_of(value);
  return message;
}

json reply_to_parameter_verb(RemoteNetwork& network, const std::string& verb, const json& request) {
  auto found = node_named(network, request.value("name", ""));
  if (!found) return reply_of(found.error());
  const std::string& node = found.value();
  if (verb == "param.list") return list(network, node);
  if (verb == "param.delete") return set_one(network, node, {request.value("parameter", ""), ParameterValue{}});
  if (verb != "param.set") return reply_of({"request '" + verb + "'", "cannot be asked of nodes outside", ""});
  if (request.contains("assignments")) return set_many(network, node, request["assignments"]);
  auto parameter = session::parameter_of_assignment(request.value("assignment", ""));
  if (!parameter) return reply_of(parameter.error());
  return set_one(network, node, parameter.value());
}

}  // namespace nacelle::remote
