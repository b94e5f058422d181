// SPDX-License-Identifier: Apache-2.0
#include "requests/service_verbs.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/client.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/runtime/service_fault.hpp"

namespace nacelle::requests {

using control::reply_of;
using nlohmann::json;

Answer call_service(const Clock& clock, const StartCall& start, msgs::TypeLibrary& types, const json& request,
                    const std::string& see) {
  constexpr double kShortest_s = 0.001, kLongest_s = 86400.0;
  const std::string name = request.value("service", "");
  auto found = types.find(request.value("type", ""));
  if (!found) return reply_of(found.error());
  const msgs::ServiceType* const type = found.value().service;
  if (type == nullptr) return reply_of({std::string{found.value().name()}, "is not a service", ""});
  msgs::AnyMessage message{type->request()};
  const std::string values =
      request.value("request", json::object()).dump(-1, ' ', false, json::error_handler_t::replace);
  if (auto read = msgs::from_json(values, type->request(), message.get()); !read) return reply_of(read.error());

  const double limit_s = std::clamp(request.value("timeout_s", 10.0), kShortest_s, kLongest_s);
  auto late = std::make_unique<LateReply>();
  late->due = clock.now() + from_seconds(limit_s);
  std::string way_out = "its node is busy or hangs";
  if (!see.empty()) way_out += ": " + see;
  if (const std::string option = request.value("limit_option", ""); !option.empty())
    way_out += "; or give " + option + " more";
  late->too_late = {"service " + name, fmt::format("has not answered within {:g} s", limit_s), std::move(way_out),
                    runtime::ServiceFault::NoAnswer, name};
  auto call = start(name, *type, message.get(), [bell = late->bell] { bell->ring(); });
  if (!call) return reply_of(call.error());
  late->finish = [call = std::shared_ptr<runtime::ServiceCall>(std::move(call).value()), type, name, see]() -> json {
    if (call->response() == nullptr)
      return reply_of({"service " + name, "its node was unloaded, or failed, before it answered", see,
                       runtime::ServiceFault::ServerGone, name});
    return {{"ok", true},
            {"type", type->name},
            {"response", parse_json_or_discard(msgs::to_json(type->response(), call->response()))}};
  };
  return late;
}

}  // namespace nacelle::requests
