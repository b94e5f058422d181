// SPDX-License-Identifier: Apache-2.0
#include "session/fault_topics.hpp"

#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>

namespace nacelle::session {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;

// Numbers and labels of rcl_lifecycle's default_state_machine.c.
TEST(TransitionNames, are_those_of_lifecycle_msgs) {
  using S = StateId;
  const struct {
    S from, to;
    int id;
    const char* label;
  } steps[] = {
      {S::Unconfigured, S::Configuring, 1, "configure"},
      {S::Configuring, S::Inactive, 10, "transition_success"},
      {S::Configuring, S::Unconfigured, 11, "transition_failure"},
      {S::Configuring, S::ErrorProcessing, 12, "transition_error"},
      {S::Inactive, S::CleaningUp, 2, "cleanup"},
      {S::CleaningUp, S::Unconfigured, 20, "transition_success"},
      {S::Inactive, S::Activating, 3, "activate"},
      {S::Activating, S::Active, 30, "transition_success"},
      {S::Activating, S::Inactive, 31, "transition_failure"},
      {S::Active, S::Deactivating, 4, "deactivate"},
      {S::Deactivating, S::Inactive, 40, "transition_success"},
      {S::Deactivating, S::ErrorProcessing, 42, "transition_error"},
      {S::Unconfigured, S::ShuttingDown, 5, "shutdown"},
      {S::Inactive, S::ShuttingDown, 6, "shutdown"},
      {S::Active, S::ShuttingDown, 7, "shutdown"},
      {S::ShuttingDown, S::Finalized, 50, "transition_success"},
      {S::ErrorProcessing, S::Unconfigured, 60, "transition_success"},
      {S::ErrorProcessing, S::Finalized, 61, "transition_failure"},
      {S::Active, S::ErrorProcessing, 99, "transition_error"},
  };
  for (const auto& step : steps) {
    const TransitionName name = name_of_step(step.from, step.to);
    EXPECT_EQ(name.id, step.id) << to_text(step.from) << " -> " << to_text(step.to);
    EXPECT_STREQ(name.label, step.label) << to_text(step.from) << " -> " << to_text(step.to);
  }
}

/// A LiDAR whose cable is pulled, an IMU that is well, and a reader of /diagnostics.
struct DiagnosticsOfFaults : ::testing::Test {
  DiagnosticsOfFaults() {
    lidar.node = "/lidar";
    lidar.plugin = "nacelle::lidar::LidarComponent";
    lidar.state = imu.state = StateId::Active;
    lidar.open_faults = {{"DEVICE_LOST", "/dev/ttyUSB0: silent for 0.4 s"}};
    imu.node = "/imu";
  }
  /// Publishes, and returns what a tool reads then. Nothing: no message was published.
  std::vector<DiagnosticStatus> publish() {
    lasts = topics.publish_diagnostics({lidar, imu}, {});
    std::vector<DiagnosticStatus> heard;
    while (Block* const block = tool->take()) {
      for (const auto& status : static_cast<const DiagnosticArray*>(block->message)->status) heard.push_back(status);
      drop_reference(*block);
    }
    return heard;
  }
  static std::string value_of(const DiagnosticStatus& status, const std::string& key) {
    for (const auto& pair : status.values) {
      if (pair.key == key) return pair.value;
    }
    return "no such key";
  }

  const SystemClock clock;
  runtime::Container container{{}, clock};
  FaultTopics topics{container};
  std::unique_ptr<Reader> tool = container.transport().create_reader(
      {"/diagnostics", &DiagnosticArray::message_type(), QoS{10}, "/tool"}, Taking::Share, nullptr);
  runtime::ComponentInfo lidar, imu;
  bool lasts = false;  ///< What publish_diagnostics() returned.
};

TEST_F(DiagnosticsOfFaults, an_open_fault_is_an_error_of_an_active_component) {
  runtime::FaultEvent event{
      0, "/lidar", "DEVICE_LOST", "/dev/ttyUSB0: silent for 0.4 s", "thread lidar_rx", clock.wall_now()};
  event.is_open_fault = true;
  container.tell_open_fault(event);

  const auto heard = publish();

  EXPECT_TRUE(lasts);
  ASSERT_EQ(heard.size(), 1U) << "the IMU is well";
  EXPECT_EQ(heard[0].level, DiagnosticStatus::ERROR);
  EXPECT_EQ(heard[0].name, "/lidar");
  EXPECT_EQ(heard[0].hardware_id, "nacelle::lidar::LidarComponent");
  EXPECT_EQ(heard[0].message, "DEVICE_LOST: /dev/ttyUSB0: silent for 0.4 s");
  EXPECT_EQ(value_of(heard[0], "code"), "DEVICE_LOST");
  EXPECT_EQ(value_of(heard[0], "state"), "active");
  EXPECT_EQ(value_of(heard[0], "faults"), "1");
  EXPECT_EQ(value_of(heard[0], "callback"), "thread lidar_rx");
}

TEST_F(DiagnosticsOfFaults, an_open_fault_is_repeated_while_it_lasts_and_its_end_is_published_once) {
  for (int beat = 0; beat < 3; ++beat) {
    const auto heard = publish();
    ASSERT_EQ(heard.size(), 1U) << beat;
    EXPECT_EQ(heard[0].level, DiagnosticStatus::ERROR) << beat;
    EXPECT_TRUE(lasts) << "the fault lasts, so another beat follows";
  }
  lidar.open_faults.clear();

  const auto heard = publish();

  EXPECT_FALSE(lasts);
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].name, "/lidar");
  EXPECT_EQ(heard[0].level, DiagnosticStatus::OK);
  EXPECT_EQ(heard[0].message, "active");
  EXPECT_TRUE(publish().empty()) << "once";
}

TEST_F(DiagnosticsOfFaults, the_reason_of_a_faulted_component_goes_before_its_open_faults) {
  lidar.fault = {"EXCEPTION", "cannot bear that byte"};
  const auto heard = publish();
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].message, "EXCEPTION: cannot bear that byte");
}

}  // namespace
}  // namespace nacelle::session
