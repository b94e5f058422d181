// SPDX-License-Identifier: Apache-2.0
#include "requests/qos_json.hpp"

#include <nlohmann/json.hpp>

#include "nacelle/base/time.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle::requests {
namespace {

using nlohmann::json;

/// Seconds, or null for "for ever".
json seconds_or_null(Duration time) { return time == Duration::zero() ? json(nullptr) : json(to_seconds(time)); }

}  // namespace

json json_of(const QoS& qos) {
  return {{"reliability", to_text(qos.reliability())},
          {"history", to_text(qos.history())},
          {"depth", qos.depth()},
          {"durability", to_text(qos.durability())},
          {"lifespan_s", seconds_or_null(qos.lifespan())},
          {"deadline_s", seconds_or_null(qos.deadline())},
          {"liveliness", to_text(qos.liveliness())},
          {"liveliness_lease_s", seconds_or_null(qos.liveliness_lease_duration())}};
}

}  // namespace nacelle::requests
