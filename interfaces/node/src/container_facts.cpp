// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/container_facts.hpp"

#include "nacelle/node/network_facts.hpp"

namespace nacelle {

std::shared_ptr<void> make_container_facts() { return std::make_shared<ContainerFacts>(); }
std::shared_ptr<void> make_network_facts() { return std::make_shared<NetworkFacts>(); }

}  // namespace nacelle
