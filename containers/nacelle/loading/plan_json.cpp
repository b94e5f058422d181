// SPDX-License-Identifier: Apache-2.0
#include "loading/plan_json.hpp"

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "nacelle/node/parameter.hpp"

namespace nacelle::loading {
namespace {

using nlohmann::json;

std::string hex_text(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%a", value);
  return text;
}
double hex_number(const json& text) { return std::strtod(text.get_ref<const std::string&>().c_str(), nullptr); }

json value_to_json(const ParameterValue& value) {
  json row{{"type", value.index()}};
  std::visit(
      [&](const auto& v) {
        using V = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<V, double>) {
          row["value"] = hex_text(v);
        } else if constexpr (std::is_same_v<V, std::vector<double>>) {
          row["value"] = json::array();
          for (const double number : v) row["value"].push_back(hex_text(number));
        } else if constexpr (!std::is_same_v<V, std::monostate>) {
          row["value"] = v;
        }
      },
      value);
  return row;
}

ParameterValue value_from_json(const json& row) {
  const json& value = row.contains("value") ? row.at("value") : row;
  switch (static_cast<ParameterType>(row.at("type").get<unsigned>())) {
    case ParameterType::NotSet: return {};
    case ParameterType::Bool: return value.get<bool>();
    case ParameterType::Integer: return value.get<std::int64_t>();
    case ParameterType::Double: return hex_number(value);
    case ParameterType::String: return value.get<std::string>();
    case ParameterType::ByteArray: return value.get<std::vector<std::uint8_t>>();
    case ParameterType::BoolArray: return value.get<std::vector<bool>>();
    case ParameterType::IntegerArray: return value.get<std::vector<std::int64_t>>();
    case ParameterType::DoubleArray: {
      std::vector<double> numbers;
      for (const auto& number : value) numbers.push_back(hex_number(number));
      return numbers;
    }
    case ParameterType::StringArray: return value.get<std::vector<std::string>>();
  }
  throw std::invalid_argument("a parameter of no known type");
}

template <typename T>
void put(json& row, const char* key, const std::optional<T>& value) {
  if (!value) return;
  if constexpr (std::is_enum_v<T>) {
    row[key] = static_cast<unsigned>(*value);
  } else if constexpr (std::is_same_v<T, Duration>) {
    row[key] = value->count();
  } else {
    row[key] = *value;
  }
}

template <typename T>
void get(const json& row, const char* key, std::optional<T>& value) {
  if (!row.contains(key)) return;
  if constexpr (std::is_enum_v<T>) {
    value = static_cast<T>(row.at(key).get<unsigned>());
  } else if constexpr (std::is_same_v<T, Duration>) {
    value = Duration{row.at(key).get<std::int64_t>()};
  } else {
    value = row.at(key).get<T>();
  }
}

/// Every policy, so that it can be applied to any QoS and gives this one.
QosPatch patch_of(const QoS& qos) {
  QosPatch patch;
  patch.reliability = qos.reliability();
  patch.durability = qos.durability();
  patch.history = qos.history();
  if (qos.history() != History::KeepAll) patch.depth = qos.depth();
  patch.deadline = qos.deadline();
  patch.lifespan = qos.lifespan();
  patch.liveliness = qos.liveliness();
  patch.lease = qos.liveliness_lease_duration();
  patch.max_samples = qos.max_samples();
  patch.max_blocking_time = qos.max_blocking_time();
  patch.when_dry = qos.when_dry();
  return patch;
}

/// Every policy of a patch, by its key in launch files (but `profile`, which has been looked up).
template <typename Patch, typename F>
void for_each_policy(Patch& patch, F&& visit) {
  visit("reliability", patch.reliability);
  visit("durability", patch.durability);
  visit("history", patch.history);
  visit("depth", patch.depth);
  visit("deadline", patch.deadline);
  visit("lifespan", patch.lifespan);
  visit("liveliness", patch.liveliness);
  visit("lease", patch.lease);
  visit("max_samples", patch.max_samples);
  visit("max_blocking_time", patch.max_blocking_time);
  visit("when_dry", patch.when_dry);
}

json patch_to_json(const QosPatch& patch) {
  json row = json::object();
  for_each_policy(patch, [&](const char* key, const auto& value) { put(row, key, value); });
  return row;
}

QosPatch patch_from_json(const json& row) {
  QosPatch patch;
  for_each_policy(patch, [&](const char* key, auto& value) { get(row, key, value); });
  return patch;
}

}  // namespace

json parameters_to_json(const std::vector<launch::Parameter>& parameters) {
  json rows = json::array();
  for (const auto& parameter : parameters)
    rows.push_back({{"name", parameter.name}, {"is", value_to_json(parameter.value)}});
  return rows;
}

std::vector<launch::Parameter> parameters_from_json(const json& rows) {
  std::vector<launch::Parameter> parameters;
  for (const auto& row : rows)
    parameters.push_back({.name = row.at("name").get<std::string>(), .value = value_from_json(row.at("is"))});
  return parameters;
}

json plan_to_json(const launch::ComponentPlan& plan) {
  json row{{"plugin", plan.plugin}, {"name", plan.name}, {"namespace", plan.namespace_}};
  row["parameters"] = parameters_to_json(plan.parameters);
  row["remaps"] = row["qos"] = json::array();
  for (const auto& rule : plan.remaps) row["remaps"].push_back(to_text(rule));
  for (const auto& qos : plan.qos) {
    json entry{{"topic", qos.topic}, {"publisher", qos.side == launch::Side::Publisher}};
    entry["patch"] = patch_to_json(qos.patch);
    if (qos.start) entry["start"] = patch_to_json(patch_of(*qos.start));
    row["qos"].push_back(std::move(entry));
  }
  row["thread"] = {{"own", plan.thread.own},
                   {"priority", plan.thread.priority},
                   {"cpus", plan.thread.cpus},
                   {"threads", plan.thread.threads}};
  return row;
}

launch::ComponentPlan plan_from_json(const json& row) {
  launch::ComponentPlan plan;
  plan.plugin = row.at("plugin").get<std::string>();
  plan.name = row.at("name").get<std::string>();
  plan.namespace_ = row.at("namespace").get<std::string>();
  plan.parameters = parameters_from_json(row.at("parameters"));
  for (const auto& text : row.at("remaps")) {
    auto rule = parse_remap_rule(text.get<std::string>());
    if (!rule) throw std::invalid_argument("remap rule '" + text.get<std::string>() + "': " + rule.error().text());
    plan.remaps.push_back(std::move(rule).value());
  }
  for (const auto& entry : row.at("qos")) {
    launch::TopicQos qos;
    qos.topic = entry.at("topic").get<std::string>();
    qos.side = entry.at("publisher").get<bool>() ? launch::Side::Publisher : launch::Side::Subscription;
    qos.patch = patch_from_json(entry.at("patch"));
    if (entry.contains("start")) qos.start = patch_from_json(entry.at("start")).applied_to(QoS{1});
    plan.qos.push_back(std::move(qos));
  }
  const json& thread = row.at("thread");
  plan.thread.own = thread.at("own").get<bool>();
  plan.thread.priority = thread.at("priority").get<int>();
  plan.thread.cpus = thread.at("cpus").get<std::vector<int>>();
  plan.thread.threads = thread.at("threads").get<std::uint32_t>();
  return plan;
}

}  // namespace nacelle::loading
