// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Thrower final : public Node {
 public:
  explicit Thrower(const NodeOptions& options) : Node("thrower", options) {
    throw std::runtime_error("no such calibration file: /nowhere");
  }
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Thrower)
