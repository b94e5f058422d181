// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/network_verbs.hpp"

#include <nlohmann/json.hpp>

#include "nacelle/control/client.hpp"
#include "nacelle/session/session.hpp"

namespace nacelle::session {

using nlohmann::json;

json reply_to_network_verb(Session& session, const std::string& verb, const json& request) {
  Network& network = session.network();
  if (verb == "network.show") {
    const bool exported = request.at("exported").get<bool>();
    const auto mode = exported ? launch::NetworkMode::Export : network.unexported();
    const auto shown = network.show(mode, exported ? "nacelle export on" : "nacelle export off");
    if (!shown) return control::reply_of(shown.error());
  } else if (verb != "network") {
    return control::reply_of(
        {"request '" + verb + "'", "is unknown to this container", "use the `nacelle` that started the container"});
  }
  json state = network.state();
  state["ok"] = true;
  state["container"] = session.options().container_name;
  return state;
}

}  // namespace nacelle::session
