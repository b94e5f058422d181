// SPDX-License-Identifier: Apache-2.0
#include "isolation/carriers.hpp"

#ifdef NACELLE_HAS_ICEORYX
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#endif

namespace nacelle::isolation {

const std::vector<std::string>& carrier_names() {
  static const std::vector<std::string> names{
#ifdef NACELLE_HAS_ICEORYX
      "iceoryx",
#endif
  };
  return names;
}

Result<std::unique_ptr<Carrier>, Problem> start_carrier(const std::string& name) {
#ifdef NACELLE_HAS_ICEORYX
  if (name == "iceoryx") {
    auto started = transport_iceoryx::IceoryxCarrier::start();
    if (!started) return err(started.error());
    return std::unique_ptr<Carrier>{std::move(started).value()};
  }
#endif
  return err(Problem{
      "carrier '" + name + "'", name == "iceoryx" ? "this program was built without it" : "there is no such carrier",
      name == "iceoryx" ? "install libiceoryx-posh-dev and build again" : suggestion(name, carrier_names())});
}

}  // namespace nacelle::isolation
