// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"

namespace nacelle::test {

int defined_nowhere(int value);

class MissingSymbol final : public Node {
 public:
  explicit MissingSymbol(const NodeOptions& options) : Node("missing_symbol", options) { value_ = defined_nowhere(1); }

 private:
  int value_ = 0;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::MissingSymbol)
