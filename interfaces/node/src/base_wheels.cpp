// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/base_wheels.hpp"

namespace nacelle {

std::shared_ptr<void> make_base_wheels() { return std::make_shared<BaseWheelsList>(); }

}  // namespace nacelle
