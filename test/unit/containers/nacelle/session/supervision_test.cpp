// SPDX-License-Identifier: Apache-2.0
#include "session/supervision.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "session/comeback.hpp"
#include "unit/containers/nacelle/scripted_robot.hpp"

namespace nacelle::session {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// As a launch file has it: two restarts, half a second before each.
FaultHandling twice() { return {.policy = FaultPolicy::Restart, .max_restarts = 2, .backoff = 500ms}; }
FaultHandling stops() { return {.policy = FaultPolicy::StopRobot}; }

class SupervisionTest : public ::testing::Test {
 protected:
  SupervisionTest() {
    supervision_ = std::make_unique<Supervision>(SupervisedRun{
        robot_, robot_.clock_, bell_, [this](const std::string& line) { said_.push_back(line); }, left_out_, crashes_});
  }
  ~SupervisionTest() override {
    supervision_.reset();
    for (const int descriptor : line_) ::close(descriptor);
  }
  /// Faults a component, and serves the supervision until it has dealt with that.
  void fault(const test::ScriptedComponent& component) {
    const int before = robot_.changes_;
    component.node->fault("TOLD_TO", "a fault on command");
    while (robot_.changes_ == before) {
      wait();
      supervision_->work();
    }
  }
  void wait() {
    pollfd wait{bell_.descriptor(), POLLIN, 0};
    ASSERT_EQ(::poll(&wait, 1, 20'000), 1) << "only a broken container takes so long";
    bell_.silence();
  }
  /// Tells time until a restart is due, and carries it out.
  void restart_is_due() {
    const auto due = supervision_->next_due();
    ASSERT_TRUE(due);
    robot_.clock_.advance(500ms);
    supervision_->work();
  }
  [[nodiscard]] nacelle_interfaces::msg::FaultyComponent row_of(const std::string& node) const {
    const auto report = supervision_->report();
    const auto found = std::ranges::find(report.components, node, &nacelle_interfaces::msg::FaultyComponent::node);
    return found == report.components.end() ? nacelle_interfaces::msg::FaultyComponent{} : *found;
  }

  Bell bell_;
  int line_[2] = {-1, -1};
  test::ScriptedComponent lidar_, imu_, base_{line_for_base()};
  test::ScriptedRobot robot_;
  std::vector<std::string> said_;
  std::vector<ComposedComponent> left_out_;
  EarlyCrashes crashes_{::testing::TempDir() + "supervision_test.crashes"};
  std::unique_ptr<Supervision> supervision_;

 private:
  int line_for_base() {
    EXPECT_EQ(pipe2(line_, O_NONBLOCK | O_CLOEXEC), 0);
    return line_[1];
  }
};

TEST_F(SupervisionTest, restarts_a_component_after_its_pause_and_no_more_often_than_it_may) {
  robot_.start("lidar", lidar_, twice());
  for (const std::uint32_t count : {1U, 2U}) {
    fault(lidar_);
    EXPECT_EQ(row_of("/lidar").restarts, count);
    EXPECT_THAT(row_of("/lidar").next_restart_s, ElementsAre(0.5));
    supervision_->work();
    EXPECT_EQ(lidar_.loads, static_cast<int>(count)) << "not before its time";
    restart_is_due();
    EXPECT_EQ(lidar_.loads, static_cast<int>(count) + 1);
    EXPECT_EQ(robot_.find("/lidar").state, StateId::Active) << "it returns to its previous state";
    EXPECT_EQ(robot_.find("/lidar").fault.code, "");
  }
  fault(lidar_);
  robot_.clock_.advance(1h);
  supervision_->work();
  EXPECT_EQ(lidar_.loads, 3);
  EXPECT_EQ(robot_.find("/lidar").fault.code, "TOLD_TO");
  EXPECT_THAT(said_,
              ElementsAre("nacelle: /lidar is restarted in 0.5 s (1 of 2)", "nacelle: /lidar was restarted (1 of 2)",
                          "nacelle: /lidar is restarted in 0.5 s (2 of 2)", "nacelle: /lidar was restarted (2 of 2)",
                          HasSubstr("/lidar stays faulted: it was restarted 2 times")));
}

TEST_F(SupervisionTest, restarts_what_was_inactive_as_inactive) {
  robot_.start("lidar", lidar_, twice(), launch::TargetState::Inactive);
  fault(lidar_);
  EXPECT_EQ(supervision_->target_of_restart("/lidar"), launch::TargetState::Inactive);
  restart_is_due();
  EXPECT_EQ(robot_.find("/lidar").state, StateId::Inactive);
}

TEST_F(SupervisionTest, counts_a_restart_that_fails_and_tries_again) {
  robot_.start("lidar", lidar_, twice());
  fault(lidar_);
  lidar_.fails_to_load = true;
  restart_is_due();
  EXPECT_THAT(said_.back(), HasSubstr("/lidar is restarted in 0.5 s (2 of 2)"));
  EXPECT_EQ(robot_.find("/lidar").node, "") << "it is not loaded";
  lidar_.fails_to_load = false;
  restart_is_due();
  EXPECT_EQ(robot_.find("/lidar").state, StateId::Active);
}

TEST_F(SupervisionTest, leaves_alone_what_was_mended_or_taken_out_by_hand) {
  robot_.start("lidar", lidar_, twice());
  const auto imu = robot_.start("imu", imu_, twice());
  fault(lidar_);
  fault(imu_);
  ASSERT_TRUE(robot_.bring_to(robot_.find("/lidar"), launch::TargetState::Inactive));
  ASSERT_TRUE(robot_.container().unload(imu.id));
  restart_is_due();
  EXPECT_EQ(lidar_.loads, 1);
  EXPECT_EQ(robot_.find("/lidar").state, StateId::Inactive);
  EXPECT_EQ(imu_.loads, 1);
  EXPECT_EQ(robot_.find("/imu").node, "");
}

TEST_F(SupervisionTest, stops_the_robot_for_a_component_whose_policy_is_that) {
  std::vector<std::string> deactivated;
  const auto record = [&deactivated](test::ScriptedComponent& component, const std::string& name) {
    component.script = [&deactivated, name](Transition transition) {
      if (transition == Transition::Deactivate) deactivated.push_back(name);
      return "";
    };
  };
  record(base_, "base");
  record(lidar_, "lidar");
  robot_.start("base", base_);
  robot_.start("lidar", lidar_);
  robot_.start("imu", imu_, stops());
  imu_.node->fault("TOLD_TO", "a fault on command");
  while (supervision_->why_to_stop().empty()) wait();
  EXPECT_THAT(supervision_->why_to_stop(), HasSubstr("/imu is faulted (TOLD_TO: a fault on command)"));
  supervision_->work();
  EXPECT_TRUE(supervision_->has_stopped_the_robot());
  EXPECT_EQ(supervision_->report().robot_stopped_by, "/imu");
  for (const char* name : {"/base", "/lidar"}) EXPECT_EQ(robot_.find(name).state, StateId::Inactive) << name;
  EXPECT_THAT(deactivated, ElementsAre("base", "lidar")) << "actuators first, though it became active before";
  char stop = 0;
  EXPECT_EQ(::read(line_[0], &stop, 1), 1) << "its stop frame was written";
  EXPECT_THAT(said_.back(), HasSubstr("the robot is stopped: /imu is faulted"));
}

TEST_F(SupervisionTest, restarts_nothing_once_the_robot_is_stopped) {
  robot_.start("lidar", lidar_, twice());
  robot_.start("base", base_);  // what moves something stops the robot, unless its entry says otherwise
  fault(lidar_);
  ASSERT_TRUE(supervision_->target_of_restart("/lidar"));
  fault(base_);
  EXPECT_TRUE(supervision_->has_stopped_the_robot());
  robot_.clock_.advance(1h);
  supervision_->work();
  EXPECT_EQ(lidar_.loads, 1);
}

TEST_F(SupervisionTest, a_fault_that_nothing_follows_is_reported_with_its_cause) {
  robot_.start("lidar", lidar_);
  fault(lidar_);
  const auto row = row_of("/lidar");
  EXPECT_EQ(row.state, "unconfigured");
  EXPECT_EQ(row.policy, "degrade");
  ASSERT_EQ(row.fault.size(), 1U);
  EXPECT_EQ(row.fault.front().code, "TOLD_TO");
  EXPECT_FALSE(supervision_->has_stopped_the_robot());
  EXPECT_EQ(robot_.changes_, 1) << "the composition is kept anew";
}

TEST_F(SupervisionTest, reports_the_containers_own_fault_until_it_is_cleared) {
  supervision_->set_own_fault({"out_of_descriptors", "all 64 are in use"});
  ASSERT_EQ(supervision_->report().container_fault.size(), 1U);
  EXPECT_EQ(supervision_->report().container_fault.front().code, "out_of_descriptors");
  supervision_->set_own_fault({});
  EXPECT_THAT(supervision_->report().container_fault, IsEmpty());
}

TEST_F(SupervisionTest, what_was_left_out_is_reported_until_it_is_loaded) {
  left_out_.push_back({lidar_.plan("lidar"), false});
  supervision_->publish();
  ASSERT_EQ(supervision_->report().left_out.size(), 1U);
  EXPECT_EQ(supervision_->report().left_out.front().node, "/lidar");
  robot_.start("lidar", lidar_);
  EXPECT_THAT(supervision_->report().left_out, IsEmpty());
}

class ComebackTest : public SupervisionTest {
 protected:
  Composition composition() { return composition_of(robot_, *supervision_, left_out_); }
};

TEST_F(ComebackTest, holds_each_component_with_its_state_and_what_moves_something) {
  robot_.start("lidar", lidar_, {}, launch::TargetState::Inactive);
  robot_.start("base", base_);
  robot_.emergency_stops_ = {"/emergency_stop"};
  const auto held = composition();
  EXPECT_EQ(held.container, "robot");
  EXPECT_THAT(held.emergency_stops, ElementsAre("/emergency_stop"));
  ASSERT_EQ(held.components.size(), 2U);
  EXPECT_EQ(held.components[0].plan.full_name(), "/lidar");
  EXPECT_EQ(held.components[0].plan.target, launch::TargetState::Inactive);
  EXPECT_FALSE(held.components[0].actuator);
  EXPECT_EQ(held.components[1].plan.target, launch::TargetState::Active);
  EXPECT_TRUE(held.components[1].actuator);
}

TEST_F(ComebackTest, what_waits_for_its_restart_comes_back_to_where_it_was) {
  robot_.start("lidar", lidar_, twice());
  fault(lidar_);
  ASSERT_EQ(robot_.find("/lidar").state, StateId::Unconfigured);
  EXPECT_EQ(composition().components.at(0).plan.target, launch::TargetState::Active);
}

TEST_F(ComebackTest, what_was_left_out_stays_known_and_once) {
  left_out_.push_back({lidar_.plan("lidar"), false});
  EXPECT_EQ(composition().components.size(), 1U);
  robot_.start("lidar", lidar_);
  EXPECT_EQ(composition().components.size(), 1U);
}

TEST_F(SupervisionTest, a_fault_with_restart_container_asks_for_a_restart_and_keeps_the_states) {
  robot_.start("lidar", lidar_, {.policy = FaultPolicy::RestartContainer});
  robot_.start("imu", imu_);
  EXPECT_EQ(supervision_->why_to_restart(), "");

  fault(lidar_);

  EXPECT_THAT(supervision_->why_to_restart(), HasSubstr("/lidar is faulted (TOLD_TO: a fault on command)"));
  EXPECT_TRUE(supervision_->has_stopped_the_robot());
  EXPECT_EQ(robot_.find("/imu").state, StateId::Active) << "the way down ends it, in order";
  const Composition kept = composition_of(robot_, *supervision_, left_out_);
  for (const auto& component : kept.components)
    EXPECT_EQ(component.plan.target, launch::TargetState::Active) << component.plan.full_name();
}

TEST_F(SupervisionTest, a_fault_with_restart_container_writes_the_stop_frames_at_once) {
  robot_.start("base", base_);
  robot_.start("lidar", lidar_, {.policy = FaultPolicy::RestartContainer});
  lidar_.node->fault("TOLD_TO", "a fault on command");
  while (supervision_->why_to_stop().empty()) wait();
  EXPECT_THAT(supervision_->why_to_stop(), HasSubstr("/lidar is faulted")) << "a bring-up ends";
  char frame = 0;
  EXPECT_EQ(::read(line_[0], &frame, 1), 1);
  EXPECT_EQ(frame, 's');
}

}  // namespace
}  // namespace nacelle::session
