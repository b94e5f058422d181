// SPDX-License-Identifier: Apache-2.0
#include "session/emergency_stops.hpp"

#include <gtest/gtest.h>

#include <std_msgs/msg/bool.hpp>

#include "nacelle/runtime/repeat.hpp"

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
  static void say(Writer& writer, bool stop, Duration at) {
    Block* const block = writer.borrow();
    static_cast<Bool*>(block->message)->data = stop;
    runtime::repeat(writer, *block, MonotonicTime{at});
  }
  static std::vector<bool> heard(Reader& reader, std::vector<MonotonicTime>* said_at = nullptr) {
    std::vector<bool> all;
    while (Block* const block = reader.take()) {
      all.push_back(static_cast<const Bool*>(block->message)->data);
      if (said_at != nullptr) said_at->push_back(block->info.source_time);
      drop_reference(*block);
    }
    return all;
  }

  const SystemClock clock{};
  runtime::Container container{{}, clock};
  EmergencyStops stops{container};
};

TEST_F(EmergencyStopsTest, repeats_a_stop_without_history_until_it_is_released) {
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

TEST_F(EmergencyStopsTest, a_release_is_latched_for_late_joiners) {
  auto lasting = writer(latched());
  auto base = late_joiner();
  static_cast<void>(stops.look());
  say(*lasting, true);
  EXPECT_TRUE(stops.look());

  const auto released = stops.release({});
  ASSERT_TRUE(released);
  ASSERT_EQ(released.value().size(), 1U);
  EXPECT_EQ(released.value()[0].topic, "/emergency_stop");
  EXPECT_NE(released.value()[0].readers, 0U);
  EXPECT_TRUE(stops.look());
  EXPECT_TRUE(stops.set().empty());
  EXPECT_EQ(heard(*base), (std::vector<bool>{true, false}));
  lasting.reset();
  EXPECT_EQ(heard(*late_joiner()), std::vector<bool>{false});
}

TEST_F(EmergencyStopsTest, a_release_names_its_topics) {
  EXPECT_NE(stops.release({}).error().what.find("no component of this container reads"), std::string::npos);
  EXPECT_EQ(stops.release({"/odom"}).error().where.text(), "topic /odom");
  const auto released = stops.release({"/arm/emergency_stop"});
  ASSERT_TRUE(released);
  EXPECT_EQ(released.value()[0].readers, 0U);
}

TEST_F(EmergencyStopsTest, who_keeps_no_history_releases_nothing) {
  auto lasting = writer(latched());
  auto passing = writer(QoS(1).best_effort());
  static_cast<void>(stops.look());
  say(*lasting, true);
  say(*passing, false);
  EXPECT_TRUE(stops.look());
  EXPECT_EQ(stops.set(), std::vector<std::string>{"/emergency_stop"});
  EXPECT_EQ(heard(*late_joiner()), std::vector<bool>{true}) << "a latched message needs no repetition";
}

TEST_F(EmergencyStopsTest, release_of_before_the_repetition_counts) {
  auto passing = writer(QoS(1));
  auto lasting = writer(latched());
  static_cast<void>(stops.look());
  say(*passing, true, 1s);
  EXPECT_TRUE(stops.look());
  std::vector<MonotonicTime> said_at;
  EXPECT_EQ(heard(*late_joiner(), &said_at), std::vector<bool>{true});
  EXPECT_EQ(said_at, std::vector<MonotonicTime>{MonotonicTime{1s}}) << "a base compares the release with it";
  say(*lasting, false, 2s);  // it was on its way, or its clock is behind
  EXPECT_TRUE(stops.look());
  EXPECT_TRUE(stops.set().empty());
  static_cast<void>(stops.look());
  EXPECT_TRUE(stops.set().empty()) << "it has heard its own repetition";
}

TEST_F(EmergencyStopsTest, a_newer_stop_is_repeated_so_that_an_older_release_does_not_release_it_for_late_joiners) {
  auto passing = writer(QoS(1));
  auto lasting = writer(latched());
  static_cast<void>(stops.look());
  for (const Duration at : {Duration{1s}, Duration{3s}}) {
    say(*passing, true, at);
    static_cast<void>(stops.look());
  }
  say(*lasting, false, 2s);
  EXPECT_FALSE(stops.look());
  EXPECT_FALSE(stops.set().empty());
  lasting.reset();
  std::vector<MonotonicTime> said_at;
  EXPECT_EQ(heard(*late_joiner(), &said_at), std::vector<bool>{true});
  EXPECT_EQ(said_at, std::vector<MonotonicTime>{MonotonicTime{3s}});
}

TEST_F(EmergencyStopsTest, a_stop_of_a_clock_that_is_behind_counts_after_a_release) {
  auto passing = writer(QoS(1));
  auto lasting = writer(latched());
  static_cast<void>(stops.look());
  say(*lasting, false, 5s);
  static_cast<void>(stops.look());
  say(*passing, true, 1s);
  EXPECT_TRUE(stops.look());
  EXPECT_FALSE(stops.set().empty());
  std::vector<MonotonicTime> said_at;
  ASSERT_EQ(heard(*late_joiner(), &said_at), (std::vector<bool>{false, true}));
  EXPECT_GT(said_at[1], said_at[0]) << "the release of before must not release it for a late joiner";
  say(*lasting, false, 6s);
  EXPECT_TRUE(stops.look());
  EXPECT_TRUE(stops.set().empty());
}

}  // namespace
}  // namespace nacelle::session
