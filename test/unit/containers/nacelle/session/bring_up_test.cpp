// SPDX-License-Identifier: Apache-2.0
// Whole lives of a robot whose components do what the test says: up, and down again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "nacelle/base/lifecycle_fault.hpp"
#include "session/bring_up_fault.hpp"
#include "session/session.hpp"
#include "support/no_threads.hpp"
#include "support/places.hpp"
#include "unit/containers/nacelle/scripted_robot.hpp"

namespace nacelle::session {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Ends the session as soon as it runs: the main loop is the first to look at it.
class EndWhenUp final : public ClockAlarm {
 public:
  explicit EndWhenUp(process::StopSignal& stop) : stop_(stop) { event_.ring(); }
  int descriptor() const override { return event_.descriptor(); }
  void take() override {
    event_.silence();
    was_up = true;
    stop_.raise_by_request();
  }
  bool was_up = false;

 private:
  process::StopSignal& stop_;
  Bell event_;
};

class BringUpTest : public ::testing::Test {
 protected:
  BringUpTest() {
    EXPECT_NE(::mkdtemp(folder_.data()), nullptr);
    EXPECT_EQ(::setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1), 0);
    plan_.container.name = "robot";
    plan_.container.declared = true;
    plan_.network.mode = launch::NetworkMode::Off;
  }
  ~BringUpTest() override { std::filesystem::remove_all(folder_); }

  launch::ComponentPlan& add(const std::string& name, const test::ScriptedComponent& component) {
    return plan_.components.emplace_back(component.plan(name));
  }
  /// Runs it until it is up, or has failed. Returns the exit code.
  int run() {
    SessionOptions options;
    options.container_name = "robot";
    options.clock_alarm = &alarm_;
    options.places.component_folders = {test::component_folder()};
    options.transitions_file = folder_ + "/transitions";
    testing::internal::CaptureStderr();
    Session session{plan_, std::move(options), clock_, stop_};
    session_ = &session;
    const int code = session.run();
    said_ = testing::internal::GetCapturedStderr();
    failure_ = session.failure().value_or(Problem{});
    EXPECT_THAT(said_, HasSubstr(failure_.text()));
    std::ifstream file(folder_ + "/transitions");
    for (std::string line; std::getline(file, line);) steps_.push_back(line);
    return code;
  }

  std::string folder_ = (std::filesystem::temp_directory_path() / "nacelle-bring-up-XXXXXX").string();
  const SystemClock clock_;
  process::StopSignal stop_;
  EndWhenUp alarm_{stop_};
  launch::Plan plan_;
  Session* session_ = nullptr;  ///< The last one.
  test::ScriptedComponent lidar_, imu_;
  std::string said_;
  Problem failure_;  ///< Of the last run; empty if there is none.
  std::vector<std::string> steps_;
};

TEST_F(BringUpTest, goes_up_in_the_order_of_after_and_down_in_the_reverse) {
  add("lidar", lidar_).after.push_back({.node = "/imu"});
  add("imu", imu_);
  EXPECT_EQ(run(), 0) << said_;
  EXPECT_TRUE(alarm_.was_up);
  EXPECT_EQ(failure_, Problem{});
  EXPECT_THAT(said_, HasSubstr("2 components active in "));
  std::erase_if(steps_, [](const std::string& step) { return step.find("activate") == std::string::npos; });
  EXPECT_THAT(steps_, ElementsAre("activate /imu", "activate /lidar", "deactivate /lidar", "deactivate /imu"));
}

TEST_F(BringUpTest, a_component_that_fails_ends_it_and_what_was_up_goes_down) {
  add("imu", imu_);
  auto& lidar = add("lidar", lidar_);
  lidar.after.push_back({.node = "/imu"});
  lidar.where = Place("robot.launch.yaml", 7);
  lidar_.script = [](Transition to) { return to == Transition::Activate ? "no such device" : ""; };
  EXPECT_EQ(run(), 1);
  EXPECT_FALSE(alarm_.was_up);
  EXPECT_EQ(failure_.code, LifecycleFault::TransitionFailed);
  EXPECT_EQ(failure_.where, Place("robot.launch.yaml", 7));
  EXPECT_EQ(failure_.value, "activate");
  EXPECT_EQ(failure_.what, "component lidar (nacelle::bench::Part): could not activate: no such device");
  EXPECT_THAT(steps_, testing::Contains("deactivate /imu"));
}

TEST_F(BringUpTest, goes_on_without_a_component_that_is_not_required) {
  add("imu", imu_);
  add("lidar", lidar_).required = false;
  lidar_.script = [](Transition to) { return to == Transition::Configure ? "no such device" : ""; };
  EXPECT_EQ(run(), 0) << said_;
  EXPECT_TRUE(alarm_.was_up);
  EXPECT_THAT(said_, HasSubstr("left out, since it is not required: /lidar could not configure: no such device"));
  EXPECT_THAT(said_, HasSubstr("1 component active in "));
}

TEST_F(BringUpTest, leaves_a_component_at_the_state_that_the_plan_gives) {
  add("imu", imu_).target = launch::TargetState::Inactive;
  add("lidar", lidar_).target = launch::TargetState::Unconfigured;
  EXPECT_EQ(run(), 0) << said_;
  EXPECT_THAT(steps_, ElementsAre("configure /imu", "cleanup /imu"));
}

TEST_F(BringUpTest, of_an_unsound_plan_begins_no_transition_and_reports_all_mistakes) {
  add("imu", imu_);
  add("lidar", lidar_).plugin = "nacelle::bench::Prt";
  add("odom", lidar_).parameters.push_back({.name = "spede", .value = 0.3});
  EXPECT_EQ(run(), 1);
  EXPECT_EQ(failure_.code, BringUpFault::UnsoundPlan);
  EXPECT_EQ(failure_.value, "2 errors");
  EXPECT_EQ(failure_.text(),
            "the plan is unsound: 2 errors; nothing was started; `nacelle check` tells the same without a robot");
  EXPECT_THAT(said_, HasSubstr("nacelle::bench::Prt"));
  EXPECT_THAT(said_, HasSubstr("'spede'"));
  EXPECT_THAT(steps_, IsEmpty());
}

TEST_F(BringUpTest, a_signal_while_it_goes_up_undoes_it) {
  add("imu", imu_);
  add("lidar", lidar_).after.push_back({.node = "/imu"});
  imu_.script = [this](Transition to) {
    if (to == Transition::Activate) stop_.raise_by_request();
    return "";
  };
  EXPECT_EQ(run(), 1);
  EXPECT_FALSE(alarm_.was_up);
  EXPECT_EQ(failure_.code, LifecycleFault::Interrupted);
  EXPECT_EQ(failure_.value, "a request");
  EXPECT_EQ(failure_.text(), "bring-up: interrupted by a request; everything started so far was rolled back");
  EXPECT_THAT(steps_, Not(testing::Contains("activate /lidar")));
}

TEST_F(BringUpTest, a_component_that_its_constructor_cannot_make_is_named_with_its_reason) {
  add("lidar", lidar_);
  lidar_.fails_to_load = true;
  EXPECT_EQ(run(), 1);
  EXPECT_EQ(failure_.code, BringUpFault::UnsoundPlan);
  EXPECT_EQ(failure_.value, "1 error");
  EXPECT_THAT(said_, HasSubstr("its device is gone"));
  EXPECT_THAT(steps_, IsEmpty());
}

TEST_F(BringUpTest, fails_if_a_required_component_was_unloaded_before_its_turn) {
  add("imu", imu_).where = Place("robot.launch.yaml", 7);
  add("lidar", lidar_);
  lidar_.on_load = [this] {
    const auto imu = session_->container().find("/imu");
    EXPECT_TRUE(imu && session_->container().unload(imu.value().id));
  };
  EXPECT_EQ(run(), 1);
  EXPECT_EQ(failure_.code, BringUpFault::NotLoaded);
  EXPECT_EQ(failure_.where, Place("robot.launch.yaml", 7));
  EXPECT_EQ(failure_.value, "/imu");
  EXPECT_EQ(failure_.text(), "robot.launch.yaml:7: /imu was not loaded; see above");
  EXPECT_THAT(steps_, IsEmpty());
}

TEST_F(BringUpTest, fails_if_the_process_can_start_no_thread) {
  add("imu", imu_);
  const test::NoThreads none;
  EXPECT_EQ(run(), 1);
  EXPECT_EQ(failure_.code, BringUpFault::OutOfResources);
  EXPECT_EQ(failure_.text(),
            "container: Resource temporarily unavailable; raise what the process may have: `ulimit -n`, `ulimit -u`");
  EXPECT_THAT(steps_, IsEmpty());
}

TEST_F(BringUpTest, a_wait_that_goes_round_in_a_circle_is_refused_before_anything_starts) {
  add("imu", imu_).after.push_back({.node = "/lidar"});
  add("lidar", lidar_).after.push_back({.node = "/imu"});
  EXPECT_EQ(run(), 1);
  EXPECT_EQ(failure_.code, BringUpFault::UnsoundPlan);
  EXPECT_THAT(steps_, IsEmpty());
}

}  // namespace
}  // namespace nacelle::session
