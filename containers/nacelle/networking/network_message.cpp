// SPDX-License-Identifier: Apache-2.0
#include "networking/network_message.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "nacelle/msgs/json.hpp"

namespace nacelle::networking {
namespace {

using nlohmann::json;

void wrap(json& value) {
  json list = json::array();
  if (!value.is_null()) list.push_back(std::move(value));
  value = std::move(list);
}

// A problem's JSON has its place and its value in fields of their own as well; the message has words and a code.
void reduce_to_message(json& problem) {
  constexpr std::array kFields{"where", "what", "way_out", "code"};
  json reduced = json::object();
  for (const char* const field : kFields)
    if (problem.contains(field)) reduced[field] = problem[field];
  problem = std::move(reduced);
}

}  // namespace

Result<nacelle_interfaces::msg::Network, Problem> network_message(json state) {
  for (json& rule : state["exports"])
    for (const char* const key : {"max_hz", "max_bytes"}) wrap(rule[key]);
  if (!state["security"].is_null())
    for (const char* const key : {"subject", "ends"}) wrap(state["security"][key]);
  for (const char* const key : {"security", "problem", "figures"}) wrap(state[key]);
  for (const char* const key : {"problem", "remarks"})
    for (json& problem : state[key]) reduce_to_message(problem);
  nacelle_interfaces::msg::Network message;
  const std::string text = state.dump(-1, ' ', false, json::error_handler_t::replace);
  if (auto read = msgs::from_json(text, nacelle_interfaces::msg::Network::message_type(), &message); !read)
    return err(read.error());
  return message;
}

}  // namespace nacelle::networking
