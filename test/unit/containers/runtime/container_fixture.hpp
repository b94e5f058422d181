// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <std_msgs/msg/string.hpp>

#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/test_container.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {

using std_msgs::msg::String;

/// Waits for texts on a topic, by event.
class Ear {
 public:
  Ear(Container& container, const std::string& topic, const QoS& qos = QoS(1000).transient_local())
      : ear_(container.transport(), topic, qos) {}
  std::string next() { return ear_.next().data; }

 private:
  TestSubscription<String> ear_;
};

template <typename ClockOfTest>
struct ContainerFixture : ::testing::Test {
  explicit ContainerFixture(ContainerOptions options = {}) : container(with_plugins(std::move(options)), clock) {}
  static ContainerOptions with_plugins(ContainerOptions options) {
    options.name = "test";
    options.component_path = {test::component_folder()};
    return options;
  }
  ClockOfTest clock;
  Container container;

  ComponentInfo load(const std::string& plugin, std::map<std::string, ParameterValue> parameters = {},
                     const std::string& name = "") {
    LoadRequest request;
    request.plugin = "nacelle::test::" + plugin;
    request.name = name;
    request.parameters = std::move(parameters);
    auto loaded = container.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    return loaded ? loaded.value() : ComponentInfo{};
  }
  void bring_up(std::uint64_t id) {
    EXPECT_EQ(container.trigger(id, Transition::Configure).reason, "");
    EXPECT_EQ(container.trigger(id, Transition::Activate).reason, "");
  }
  void say(const std::string& topic, const std::string& text) {
    auto writer =
        container.transport().create_writer({topic, &String::message_type(), QoS(10).transient_local(), "/mouth"});
    Block* const block = writer->borrow();
    static_cast<String*>(block->message)->data = text;
    writer->publish(*block);
    mouths.push_back(std::move(writer));
  }
  static bool is_mapped(const std::string& file) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      if (line.find(file) != std::string::npos) return true;
    }
    return false;
  }
  std::vector<std::unique_ptr<Writer>> mouths;
};
using ContainerTest = ContainerFixture<SystemClock>;

}  // namespace nacelle::runtime
