// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "../transport_traits.hpp"
#include "nacelle/runtime/broker.hpp"
#include "support/fake_transport.hpp"
#include "support/linked_brokers.hpp"

namespace nacelle {

/// A new transport that needs nothing of the machine is one line here.
using EveryTransport = ::testing::Types<runtime::Broker, test::FakeTransport, test::LinkedBrokers>;
inline constexpr NamedTransport kNamedTransports[] = {{"Broker", make_transport<runtime::Broker>},
                                                      {"Fake", make_transport<test::FakeTransport>},
                                                      {"Linked", make_transport<test::LinkedBrokers>}};

}  // namespace nacelle
