// SPDX-License-Identifier: Apache-2.0
// A component of another version of Nacelle: its ABI is another, and it may need a function that this version does not have.
#include <cstdlib>

#include "nacelle/node/component.hpp"

#undef NACELLE_COMPONENT_ABI
#define NACELLE_COMPONENT_ABI 48

namespace nacelle::test {

#ifdef NEEDS_ANOTHER_FUNCTION
void defined_in_another_version();
#else
void defined_in_another_version() {}
#endif

class OTHER_CLASS final : public Node {
 public:
  explicit OTHER_CLASS(const NodeOptions& options) : Node("other_abi", options) {
    defined_in_another_version();
    std::abort();  // it must never be constructed
  }
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::OTHER_CLASS)
