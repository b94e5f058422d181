// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <vector>

#include "every_transport.hpp"  // of the folder of this program
#include "support/manual_clock.hpp"

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
}  // namespace nacelle
