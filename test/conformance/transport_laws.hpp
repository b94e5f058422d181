// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <vector>

#include "nacelle/runtime/broker.hpp"
#include "support/fake_transport.hpp"
#include "support/linked_brokers.hpp"
#include "support/manual_clock.hpp"
#ifdef NACELLE_CONFORMANCE_OF_ICEORYX
#include "linked_by_iceoryx.hpp"
#endif

namespace nacelle {

using std_msgs::msg::String;

/// What the suites of this folder share; T is a transport over a Clock.
template <typename T>
class TransportLaws : public ::testing::Test {
 public:
  test::ManualClock clock;
  T transport{clock};

  static EndpointSpec spec(QoS qos, const std::string& topic = "/chat") {
    return {topic, &String::message_type(), qos, "/node"};
  }
  static PublishResult send(Writer& writer, const std::string& text) {
    Block* const block = writer.borrow();
    static_cast<String*>(block->message)->data = text;
    return writer.publish(*block);
  }
  static std::vector<std::string> receive(Reader& reader) {
    std::vector<std::string> all;
    while (Block* const block = reader.take()) {
      all.push_back(static_cast<const String*>(block->message)->data);
      drop_reference(*block);
    }
    return all;
  }
  using Texts = std::vector<std::string>;
};

#ifdef NACELLE_CONFORMANCE_OF_ICEORYX
/// The same suites in a program of their own, which has the daemon: a link whose streams iceoryx moves.
using EveryTransport = ::testing::Types<test::LinkedByIceoryx>;
#else
/// A new transport is one line here.
using EveryTransport = ::testing::Types<runtime::Broker, test::FakeTransport, test::LinkedBrokers>;
#endif

/// Writer and reader are in two processes: what arrives is a copy, made in a message of the reader's side.
template <typename T>
inline constexpr bool kCopies = std::is_base_of_v<test::LinkedBrokers, T>;
}  // namespace nacelle
