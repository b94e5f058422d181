// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/linked_brokers.hpp"

namespace nacelle::test {

/// Two linked brokers whose streams go through iceoryx's shared memory, wherever a carrier takes them.
class LinkedByIceoryx final : public LinkedBrokers {
 public:
  explicit LinkedByIceoryx(const Clock& clock);
};

}  // namespace nacelle::test
