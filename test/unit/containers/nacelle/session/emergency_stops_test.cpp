// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/emergency_stops.hpp"

#include <gtest/gtest.h>

#include <std_msgs/msg/bool.hpp>

namespace nacelle::session {
namespace {

using std_msgs::msg::Bool;

QoS latched() { return QoS(KeepAll{}).reliable().transient_local(); }

struct EmergencyStopsTest : ::testing::Test {
  [[nodiscard]] std::unique_ptr<Writer> writer(const QoS& qos) {
    return container.transport().create_writer({"/emergency_stop", &Bool::message_type(), qos, "/somebody"});
  }
  [[nodiscard]] std::unique_ptr<Reader> late_joiner() {
    return container.transport().create_reader({"/emergency_stop", &Bool::message_type(), latched(), "/base"},
                                               Taking::Share, nullptr);
  }
  static void say(Writer& writer, bool stop) {
    Block* const block = writer.borrow();
    static_cast<Bool*>(block->message)->data = stop;
    writer.publish(*block);
  }
  static std::vector<bool> heard(Reader& reader) {
    std::vector<bool> all;
    while (Block* const block = reader.take()) {
      all.push_back(static_cast<const Bool*>(block->message)->data);
      drop_reference(*block);
    }
    return all;
  }

  const SystemClock clock;
  runtime::Container container{{}, clock};
  EmergencyStops stops{container};
};

TEST_F(EmergencyStopsTest, one_that_keeps_no_history_is_said_again_until_it_is_released) {
  auto passing = writer(QoS(1));
  EXPECT_FALSE(stops.look());
  say(*passing, true);
  passing.reset();  // as `ros2 topic pub --once`
  EXPECT_TRUE(stops.look());
  EXPECT_EQ(stops.set(), std::vector<std::string>{"/emergency_stop"});
  EXPECT_EQ(heard(*late_joiner()), std::vector<bool>{true});
  static_cast<void>(stops.look());
  EXPECT_EQ(heard(*late_joiner()), std::vector<bool>{true}) << "it hears itself, and says it no more often";
  auto lasting = writer(latched());
  say(*lasting, false);
  EXPECT_TRUE(stops.look());
  EXPECT_TRUE(stops.set().empty());
  EXPECT_EQ(heard(*late_joiner()), std::vector<bool>{false}) << "the stop of before must not come back";
}

TEST_F(EmergencyStopsTest, who_keeps_no_history_releases_nothing) {
  auto lasting = writer(latched());
  auto passing = writer(QoS(1).best_effort());
  static_cast<void>(stops.look());
  say(*lasting, true);
  say(*passing, false);
  EXPECT_TRUE(stops.look());
  EXPECT_EQ(stops.set(), std::vector<std::string>{"/emergency_stop"});
  EXPECT_EQ(heard(*late_joiner()), std::vector<bool>{true}) << "what is latched needs no repetition";
}

}  // namespace
}  // namespace nacelle::session
