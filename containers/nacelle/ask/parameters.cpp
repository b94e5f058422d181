// SPDX-License-Identifier: Apache-2.0
#include "nacelle/ask/parameters.hpp"

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

// rcl_interfaces/msg/ParameterValue's field of each type. Source: its definition in /opt/ros or interfaces/msgs/definitions.
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

ParameterValue value_in(const json& message) {
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

/// Makes a row of list_parameters() of rcl_interfaces/msg/ParameterDescriptor.
json row_of(const json& descriptor, const ParameterValue& value) {
  json row{{"name", descriptor["name"]},
           {"type", nacelle::to_text(type_in(descriptor))},
           {"value", json_of(value)},
           {"text", launch::to_text(value)},
           {"description", descriptor["description"]},
           {"constraints", descriptor["additional_constraints"]},
           {"read_only", descriptor["read_only"]},
           {"dynamic_typing", descriptor["dynamic_typing"]}};
  for (const char* const ranges : {"floating_point_range", "integer_range"}) {
    for (const auto& range : descriptor[ranges]) {
      row["from"] = range["from_value"];
      row["to"] = range["to_value"];
      row["step"] = range["step"];
    }
  }
  return row;
}

/// Returns the values in the order of the names. rclcpp answers a question that names one parameter without a value with nothing
/// at all, so those are left out of it.
Result<std::vector<ParameterValue>, Problem> values_of(Nodes& nodes, const std::string& node, const json& names,
                                                       const Problem& changed) {
  const auto typed =
      nodes.call(node + "/get_parameter_types", "rcl_interfaces/srv/GetParameterTypes", {{"names", names}});
  if (!typed) return err(typed.error());
  const json& types = typed.value()["types"];
  if (types.size() != names.size()) return err(changed);
  json with_value = json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (types[i] != 0) with_value.push_back(names[i]);
  }
  const auto got = nodes.call(node + "/get_parameters", "rcl_interfaces/srv/GetParameters", {{"names", with_value}});
  if (!got) return err(got.error());
  const json& values = got.value()["values"];
  if (values.size() != with_value.size()) return err(changed);
  std::vector<ParameterValue> all;
  for (std::size_t i = 0, next = 0; i < names.size(); ++i)
    all.push_back(types[i] == 0 ? ParameterValue{} : value_in(values[next++]));
  return all;
}

}  // namespace

json json_of(const ParameterValue& value) { return std::visit(ToJson{}, value); }

json message_of(const ParameterValue& value) {
  json message{{"type", static_cast<int>(type_of(value))}};
  if (type_of(value) != ParameterType::NotSet) message[kFields[value.index()]] = json_of(value);
  return message;
}

Result<json, Problem> list_parameters(Nodes& nodes, const std::string& node) {
  const Problem changed{node, "its parameters changed while they were read", "try again"};
  const auto listed =
      nodes.call(node + "/list_parameters", "rcl_interfaces/srv/ListParameters", json::object());
  if (!listed) return err(listed.error());
  const json names = listed.value()["result"]["names"];
  const auto described =
      nodes.call(node + "/describe_parameters", "rcl_interfaces/srv/DescribeParameters", {{"names", names}});
  if (!described) return err(described.error());
  const json& descriptors = described.value()["descriptors"];
  if (descriptors.size() != names.size()) return err(changed);
  const auto values = values_of(nodes, node, names, changed);
  if (!values) return err(values.error());
  std::map<std::string, json> rows;
  for (std::size_t i = 0; i < names.size(); ++i)
    rows.emplace(names[i].get<std::string>(), row_of(descriptors[i], values.value()[i]));
  json all = json::array();
  for (auto& [name, row] : rows) all.push_back(std::move(row));
  return all;
}

Result<std::vector<ParameterOutcome>, Problem> set_parameters(Nodes& nodes, const std::string& node,
                                                              const std::vector<Parameter>& parameters) {
  json messages = json::array();
  for (const Parameter& parameter : parameters)
    messages.push_back({{"name", parameter.get_name()}, {"value", message_of(parameter.get_parameter_value())}});
  const auto answer =
      nodes.call(node + "/set_parameters", "rcl_interfaces/srv/SetParameters", {{"parameters", messages}});
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
  // The refusal of an unknown parameter is the middleware's; the nearest name is what helps.
  const auto listed = nodes.call(node + "/list_parameters", "rcl_interfaces/srv/ListParameters", json::object());
  if (!listed) return err(problem);
  const auto names = listed.value()["result"]["names"].get<std::vector<std::string>>();
  if (std::ranges::find(names, parameter.get_name()) == names.end()) {
    problem.what = "there is no such parameter";
    problem.way_out = suggestion(parameter.get_name(), names);
  }
  return err(problem);
}

Result<Parameter, Problem> parameter_of_assignment(const std::string& assignment) {
  auto parameter = launch::parse_parameter_assignment(assignment);
  if (!parameter) return err(Problem{assignment, parameter.error().what, parameter.error().way_out});
  if (type_of(parameter.value().second) == ParameterType::NotSet)
    return err(Problem{assignment, "gives no value", "give one; [] has no type to be told by"});
  return Parameter{parameter.value().first, parameter.value().second};
}

}  // namespace nacelle::ask
