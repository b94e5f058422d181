// SPDX-License-Identifier: Apache-2.0
#include "ask/parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include "nacelle/base/names.hpp"
#include "nacelle/launch/parameter_value.hpp"

namespace nacelle::ask {
namespace {

using nlohmann::json;

// The field of rcl_interfaces/msg/ParameterValue for each type, and the services of a node's parameters.
constexpr std::array<const char*, 10> kFields{"",
                                              "bool_value",
                                              "integer_value",
                                              "double_value",
                                              "string_value",
                                              "byte_array_value",
                                              "bool_array_value",
                                              "integer_array_value",
                                              "double_array_value",
                                              "string_array_value"};

constexpr const char* kList = "rcl_interfaces/srv/ListParameters";
constexpr const char* kDescribe = "rcl_interfaces/srv/DescribeParameters";
constexpr const char* kTypes = "rcl_interfaces/srv/GetParameterTypes";
constexpr const char* kGet = "rcl_interfaces/srv/GetParameters";
constexpr const char* kSet = "rcl_interfaces/srv/SetParameters";

json number_of(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "Infinity" : "-Infinity";
  return value;
}

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

struct ToJson {
  json operator()(std::monostate) const { return nullptr; }
  json operator()(double v) const { return number_of(v); }
  json operator()(const std::vector<double>& values) const {
    json all = json::array();
    for (const double v : values) all.push_back(number_of(v));
    return all;
  }
  template <typename T>
  json operator()(const T& v) const {
    return v;
  }
};

ParameterType type_in(const json& message) {
  const int type = message["type"].get<int>();
  return type < 0 || type >= static_cast<int>(kFields.size()) ? ParameterType::NotSet
                                                              : static_cast<ParameterType>(type);
}

/// Makes a row of list_parameters() from rcl_interfaces/msg/ParameterDescriptor.
json row_of(const json& descriptor, const ParameterValue& value) {
  json row{{"name", descriptor["name"]},
           {"type", nacelle::to_text(type_in(descriptor))},
           {"value", json_of(value)},
           {"text", launch::to_text(value)},
           {"description", descriptor["description"]},
           {"constraints", descriptor["additional_constraints"]},
           {"read_only", descriptor["read_only"]},
           {"dynamic_typing", descriptor["dynamic_typing"]}};
  for (const auto& range : descriptor["floating_point_range"]) {
    row["from"] = number_of(double_of(range["from_value"]));
    row["to"] = number_of(double_of(range["to_value"]));
    row["step"] = number_of(double_of(range["step"]));
  }
  for (const auto& range : descriptor["integer_range"]) {
    row["from"] = range["from_value"];
    row["to"] = range["to_value"];
    row["step"] = range["step"];
  }
  return row;
}

/// Returns the values in the order of the names. rclcpp answers a question that names one parameter without a value with nothing
/// at all, so those are left out of it.
Result<std::vector<ParameterValue>, Problem> values_of(Nodes& nodes, const std::string& node,
                                                       const std::vector<std::string>& names, const Problem& changed) {
  const auto typed = nodes.call(node + "/get_parameter_types", kTypes, {{"names", names}});
  if (!typed) return err(typed.error());
  const json& types = typed.value()["types"];
  if (types.size() != names.size()) return err(changed);
  json with_value = json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (types[i] != 0) with_value.push_back(names[i]);
  }
  const auto got = nodes.call(node + "/get_parameters", kGet, {{"names", with_value}});
  if (!got) return err(got.error());
  const json& values = got.value()["values"];
  if (values.size() != with_value.size()) return err(changed);
  std::vector<ParameterValue> all;
  for (std::size_t i = 0, next = 0; i < names.size(); ++i)
    all.push_back(types[i] == 0 ? ParameterValue{} : value_of(values[next++]));
  return all;
}

/// Returns true if a parameter can be changed and never undeclared.
bool has_fixed_type(Nodes& nodes, const std::string& node, const std::string& parameter) {
  const auto described = nodes.call(node + "/describe_parameters", kDescribe, {{"names", {parameter}}});
  if (!described || described.value()["descriptors"].empty()) return false;
  const json& about = described.value()["descriptors"][0];
  return !about["dynamic_typing"].get<bool>() && !about["read_only"].get<bool>();
}

}  // namespace

ParameterValue value_of(const json& message) {
  const ParameterType type = type_in(message);
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

json json_of(const ParameterValue& value) { return std::visit(ToJson{}, value); }

json message_of(const ParameterValue& value) {
  json message{{"type", static_cast<int>(type_of(value))}};
  if (type_of(value) != ParameterType::NotSet) message[kFields[value.index()]] = json_of(value);
  return message;
}

Result<std::vector<std::string>, Problem> parameter_names(Nodes& nodes, const std::string& node) {
  const auto listed = nodes.call(node + "/list_parameters", kList, json::object());
  if (!listed) return err(listed.error());
  return listed.value()["result"]["names"].get<std::vector<std::string>>();
}

Result<json, Problem> list_parameters(Nodes& nodes, const std::string& node) {
  const Problem changed{node, "its parameters changed while they were read", "try again"};
  nodes.prepare({{node + "/list_parameters", kList},
                 {node + "/describe_parameters", kDescribe},
                 {node + "/get_parameter_types", kTypes},
                 {node + "/get_parameters", kGet}});
  const auto listed = parameter_names(nodes, node);
  if (!listed) return err(listed.error());
  const auto& names = listed.value();
  const auto described = nodes.call(node + "/describe_parameters", kDescribe, {{"names", names}});
  if (!described) return err(described.error());
  const json& descriptors = described.value()["descriptors"];
  if (descriptors.size() != names.size()) return err(changed);
  const auto values = values_of(nodes, node, names, changed);
  if (!values) return err(values.error());
  std::map<std::string, json> rows;
  for (std::size_t i = 0; i < names.size(); ++i) rows.emplace(names[i], row_of(descriptors[i], values.value()[i]));
  json all = json::array();
  for (auto& [name, row] : rows) all.push_back(std::move(row));
  return all;
}

Result<std::vector<ParameterOutcome>, Problem> set_parameters(Nodes& nodes, const std::string& node,
                                                              const std::vector<Parameter>& parameters) {
  json messages = json::array();
  for (const Parameter& parameter : parameters)
    messages.push_back({{"name", parameter.get_name()}, {"value", message_of(parameter.get_parameter_value())}});
  const auto answer = nodes.call(node + "/set_parameters", kSet, {{"parameters", messages}});
  if (!answer) return err(answer.error());
  const json& results = answer.value()["results"];
  if (results.size() != parameters.size()) {
    return err(Problem{
        node,
        "answered for " + std::to_string(results.size()) + " of " + std::to_string(parameters.size()) + " parameters",
        ""});
  }
  std::vector<ParameterOutcome> outcomes;
  for (std::size_t i = 0; i < results.size(); ++i) {
    std::string refusal = results[i]["successful"].get<bool>() ? "" : results[i]["reason"].get<std::string>();
    if (!results[i]["successful"].get<bool>() && refusal.empty()) refusal = "the node refuses it and gives no reason";
    outcomes.push_back({parameters[i].get_name(), std::move(refusal)});
  }
  return outcomes;
}

Result<void, Problem> set_parameter(Nodes& nodes, const std::string& node, const Parameter& parameter) {
  const auto outcomes = set_parameters(nodes, node, {parameter});
  if (!outcomes) return err(outcomes.error());
  const std::string& refusal = outcomes.value().front().refusal;
  if (refusal.empty()) return {};
  Problem problem{node + ", parameter " + parameter.get_name(), refusal, ""};
  // A node refuses in rclcpp's words; these say more of a name that is misspelt and of a parameter that cannot go.
  const auto names = parameter_names(nodes, node);
  if (!names || names.value().empty()) return err(problem);
  if (std::ranges::find(names.value(), parameter.get_name()) == names.value().end()) {
    problem.what = "there is no such parameter";
    problem.way_out = suggestion(parameter.get_name(), names.value());
  } else if (parameter.get_type() == ParameterType::NotSet && has_fixed_type(nodes, node, parameter.get_name())) {
    problem.what = "parameter '" + parameter.get_name() + "' has a fixed type: its node declares it and needs it";
  }
  return err(problem);
}

Result<Parameter, Problem> parameter_of_assignment(const std::string& assignment) {
  auto parameter = launch::parse_parameter_assignment(assignment);
  if (!parameter) return err(Problem{assignment, parameter.error().what, parameter.error().way_out});
  if (type_of(parameter.value().second) == ParameterType::NotSet)
    return err(Problem{assignment, "gives no value", "give at least one value; the type of [] is unknown"});
  return Parameter{parameter.value().first, parameter.value().second};
}

}  // namespace nacelle::ask
