// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/container_facts.hpp"

namespace nacelle {

std::shared_ptr<void> make_container_facts() { return std::make_shared<ContainerFacts>(); }

}  // namespace nacelle
