// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/parameter_verbs.hpp"

#include <cmath>
#include <optional>

#include "nacelle/base/guarded.hpp"
#include "nacelle/control/client.hpp"
#include "nacelle/launch/parameter_value.hpp"
#include "nacelle/session/session.hpp"

namespace nacelle::session {
namespace {

using control::reply_of;
using nlohmann::json;

// A component that has not ended its callback by then is late anyway: the watchdog faults it soon.
constexpr Duration kLimit = 3s;

/// Where the answer lies until the main thread takes it; while it lives somebody wants it.
template <typename T>
using Box = Guarded<std::optional<Result<T, Problem>>>;

/// Asks with `ask(box, then)` and makes the reply with `reply(answer)`.
template <typename T, typename Ask, typename MakeReply>
std::unique_ptr<LateReply> asked(Session& session, const std::string& node, Ask&& ask, MakeReply&& reply) {
  auto late = std::make_unique<LateReply>();
  auto box = std::make_shared<Box<T>>();
  late->due = session.container().clock().now() + kLimit;
  late->too_late = {node, "its callbacks leave no time for a look at its parameters", "see `nacelle faults`"};
  ask(std::weak_ptr<void>(box), [weak = std::weak_ptr<Box<T>>(box), bell = late->bell](Result<T, Problem> answer) {
    if (const auto there = weak.lock()) *there->lock() = std::move(answer);
    bell->ring();
  });
  late->finish = [box = std::move(box), reply = std::forward<MakeReply>(reply)]() -> json {
    auto answer = box->lock();
    if (!*answer) return reply_of({"container", "the component gave no answer", ""});
    if (!**answer) return reply_of((*answer)->error());
    return reply((*answer)->value());
  };
  return late;
}

json number_of(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "Infinity" : "-Infinity";
  return value;
}

/// JSON of each alternative.
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

}  // namespace

json json_of(const runtime::ParameterReport& parameter) {
  const ParameterDescriptor& about = parameter.descriptor;
  json row{{"name", parameter.name},
           {"type", nacelle::to_text(parameter.type)},
           {"value", json_of(parameter.value)},
           {"text", launch::to_text(parameter.value)},
           {"description", about.description},
           {"constraints", about.additional_constraints},
           {"read_only", about.read_only},
           {"dynamic_typing", about.dynamic_typing},
           {"given", parameter.given}};
  if (const auto& range = about.integer_range) {
    row["from"] = range->from;
    row["to"] = range->to;
    row["step"] = range->step;
  } else if (const auto& wide = about.floating_point_range) {
    row["from"] = number_of(wide->from);
    row["to"] = number_of(wide->to);
    row["step"] = wide->step;
  }
  return row;
}

Result<Parameter, Problem> parameter_of_assignment(const std::string& assignment) {
  auto parameter = launch::parse_parameter_assignment(assignment);
  if (!parameter) return err(Problem{assignment, parameter.error().what, parameter.error().way_out});
  if (type_of(parameter.value().second) == ParameterType::NotSet)
    return err(Problem{assignment, "gives no value", "give one; [] has no type to be told by"});
  return Parameter{parameter.value().first, parameter.value().second};
}

namespace {

Answer list(Session& session, const runtime::ComponentInfo& info) {
  using Rows = std::vector<runtime::ParameterReport>;
  return asked<Rows>(
      session, info.node,
      [&](auto asker, auto then) { session.container().read_parameters(info.id, asker, std::move(then)); },
      [node = info.node](const Rows& rows) {
        json all = json::array();
        for (const auto& row : rows) all.push_back(json_of(row));
        return json{{"ok", true}, {"node", node}, {"parameters", all}};
      });
}

using Outcomes = std::vector<runtime::ParameterOutcome>;

template <typename MakeReply>
Answer set(Session& session, const runtime::ComponentInfo& info, const std::vector<Parameter>& parameters,
           MakeReply&& reply) {
  return asked<Outcomes>(
      session, info.node,
      [&](auto asker, auto then) { session.container().set_parameters(info.id, parameters, asker, std::move(then)); },
      std::forward<MakeReply>(reply));
}

Answer set_one(Session& session, const runtime::ComponentInfo& info, Parameter parameter) {
  return set(session, info, {std::move(parameter)}, [node = info.node](const Outcomes& outcomes) {
    const auto& outcome = outcomes.front();
    if (!outcome.refusal.empty()) return reply_of({node + ", parameter " + outcome.name, outcome.refusal, ""});
    return json{{"ok", true}, {"node", node}, {"name", outcome.name}};
  });
}

Answer set_many(Session& session, const runtime::ComponentInfo& info, const json& assignments) {
  std::vector<Parameter> parameters;
  for (const auto& text : assignments) {
    auto parameter = parameter_of_assignment(text.get<std::string>());
    if (!parameter) return reply_of(parameter.error());
    parameters.push_back(std::move(parameter).value());
  }
  return set(session, info, parameters, [node = info.node](const Outcomes& outcomes) {
    json results = json::array();
    for (const auto& outcome : outcomes) results.push_back({{"name", outcome.name}, {"refusal", outcome.refusal}});
    return json{{"ok", true}, {"node", node}, {"results", results}};
  });
}

}  // namespace

json json_of(const ParameterValue& value) { return std::visit(ToJson{}, value); }

Answer reply_to_parameter_verb(Session& session, const std::string& verb, const json& request) {
  auto component = session.container().find(request.value("name", ""));
  if (!component) return reply_of(component.error());
  const runtime::ComponentInfo& info = component.value();
  if (verb == "param.list") return list(session, info);
  if (verb == "param.delete") return set_one(session, info, {request.value("parameter", ""), ParameterValue{}});
  if (verb != "param.set") return reply_of({"request '" + verb + "'", "is unknown to this container", ""});
  if (request.contains("assignments")) return set_many(session, info, request["assignments"]);
  auto parameter = parameter_of_assignment(request.value("assignment", ""));
  if (!parameter) return reply_of(parameter.error());
  return set_one(session, info, std::move(parameter).value());
}

}  // namespace nacelle::session
