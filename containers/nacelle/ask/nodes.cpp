// SPDX-License-Identifier: Apache-2.0
#include "nacelle/ask/nodes.hpp"

namespace nacelle::ask {
namespace {

// The other side's own limit ends the call; this much more for its answer to arrive.
constexpr Duration kOnTheWay = 7s;

}  // namespace

Result<std::string, Problem> Nodes::find(const std::string& name) {
  auto reply = client_.call({{"verb", "node.find"}, {"name", name}}, kAnswerLimit + kOnTheWay);
  if (!reply) return err(reply.error());
  return reply.value()["node"].get<std::string>();
}

Result<nlohmann::json, Problem> Nodes::call(const std::string& service, const char* type, const nlohmann::json& request,
                                            Duration limit) {
  auto reply = client_.call({{"verb", "service.call"},
                             {"service", service},
                             {"type", type},
                             {"request", request},
                             {"timeout_s", to_seconds(limit)}},
                            limit + kOnTheWay);
  if (!reply) return err(reply.error());
  return std::move(reply.value()["response"]);
}

}  // namespace nacelle::ask
