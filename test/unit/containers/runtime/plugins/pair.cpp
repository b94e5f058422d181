// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"

namespace nacelle::test {

/// Two classes of one library.
class First final : public Node {
 public:
  explicit First(const NodeOptions& options) : Node("first", options) {}
};
class Second final : public LifecycleNode {
 public:
  explicit Second(const NodeOptions& options) : LifecycleNode("second", options) {}
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::First, nacelle::test::Second)
