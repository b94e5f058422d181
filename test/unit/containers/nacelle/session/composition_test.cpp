// SPDX-License-Identifier: Apache-2.0
#include "session/composition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "../control/temporary_folder.hpp"
#include "session/comeback.hpp"

namespace nacelle::session {
namespace {

using launch::TargetState;
using ::testing::HasSubstr;

ComposedComponent component(const std::string& name, TargetState state) {
  ComposedComponent made;
  made.plan.package = "pkg";
  made.plan.plugin = "pkg::" + name;
  made.plan.name = name;
  made.plan.namespace_ = "/";
  made.plan.target = state;
  return made;
}

Composition robot() {
  Composition all{"robot", {component("lidar", TargetState::Active), component("base", TargetState::Active)}};
  launch::ComponentPlan& lidar = all.components[0].plan;
  lidar.namespace_ = "/front";
  lidar.parameters = {{.name = "rate", .value = 0.1}, {.name = "ids", .value = std::vector<std::int64_t>{1, -2}}};
  lidar.on_fault = FaultHandling{FaultPolicy::Restart, 3, 250ms};
  lidar.after = {{"/base", launch::When::FirstMessage, "/odom", 5s, {}}};
  lidar.isolate = launch::Isolation::Process;
  all.components[1].actuator = true;
  all.emergency_stops = {"/emergency_stop", "/arm/emergency_stop"};
  return all;
}

TEST(Composition, is_read_as_it_was_written) {
  const Composition before = robot();

  const auto after = parse_composition(to_text(before), "state");

  ASSERT_TRUE(after) << after.error().text();
  EXPECT_EQ(after.value(), before);
  EXPECT_EQ(to_text(after.value()), to_text(before));
}

TEST(Composition, every_prefix_of_a_file_is_refused_or_the_whole) {
  const std::string whole = to_text(robot());
  for (std::size_t length = 0; length + 2 < whole.size(); ++length) {
    const auto parsed = parse_composition(std::string_view{whole}.substr(0, length), "state");
    ASSERT_FALSE(parsed) << "the first " << length << " bytes are taken";
    EXPECT_THAT(parsed.error().text(), HasSubstr("state: is not a state file of a container: not JSON, or cut off"));
  }
}

TEST(Composition, what_does_not_fit_is_named) {
  const struct {
    const char *from, *to, *told;
  } changes[] = {
      {"\"nacelle_composition\": 1", "\"nacelle_composition\": 2", "has the version 2, and this program reads 1"},
      {"\"state\": \"active\"", "\"state\": \"asleep\"", "'state' cannot be 'asleep'"},
      {"\"name\": \"base\"", "\"name\": \"a b\"", "a b"},
      {"\"namespace\": \"/\"", "\"namespace\": \"x\"", "the namespace 'x' is not absolute"},
      {"\"threads\": 1", "\"threads\": 0", "out of range"},
      {"\"backoff_ns\": 250000000", "\"backoff_ns\": -1", "'backoff_ns' is negative"},
      {"\"/arm/emergency_stop\"", "\"no topic\"", "holds an emergency stop that is not a topic: 'no topic'"},
      {"\"/arm/emergency_stop\"", "7", "is damaged"},
      {"\"plugin\": \"pkg::base\"", "\"plugin\": \"\"", "a component has no plugin"},
  };
  for (const auto& change : changes) {
    std::string text = to_text(robot());
    const auto at = text.find(change.from);
    ASSERT_NE(at, std::string::npos) << change.from;
    text.replace(at, std::string_view{change.from}.size(), change.to);
    const auto parsed = parse_composition(text, "state");
    ASSERT_FALSE(parsed) << change.to;
    EXPECT_THAT(parsed.error().what, HasSubstr(change.told));
  }
}

TEST(Composition, a_name_twice_is_refused) {
  Composition twice = robot();
  twice.components.push_back(twice.components[1]);

  const auto parsed = parse_composition(to_text(twice), "state");

  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().what, "holds /base twice");
}

TEST(Resumed, components_come_from_the_composition_and_policies_from_the_file) {
  launch::Plan plan;
  plan.components = {robot().components[1].plan, component("camera", TargetState::Active).plan};
  plan.components[0].budgets.resize(1);
  Composition held = robot();
  held.components[1].plan.parameters = {{.name = "speed", .value = 0.5}};

  const launch::Plan after = resumed(plan, held, "state");

  ASSERT_EQ(after.components.size(), 2U) << "the camera had been taken out by hand";
  EXPECT_EQ(after.components[0].full_name(), "/front/lidar") << "loaded by hand";
  EXPECT_EQ(after.components[1].full_name(), "/base");
  EXPECT_EQ(after.components[1].budgets.size(), 1U) << "of the launch file";
  ASSERT_EQ(after.components[1].parameters.size(), 1U);
  EXPECT_EQ(after.components[1].parameters[0].name, "speed") << "as it was set";
}

TEST(Resumed, what_moves_something_comes_back_inactive_by_default) {
  Composition held = robot();
  EXPECT_EQ(resumed({}, held, "state").components[0].target, TargetState::Active);
  EXPECT_EQ(resumed({}, held, "state").components[1].target, TargetState::Inactive);

  held.components[1].plan.resume_active = true;
  EXPECT_EQ(resumed({}, held, "state").components[1].target, TargetState::Active);

  held.components[1].plan.target = TargetState::Unconfigured;
  EXPECT_EQ(resumed({}, held, "state").components[1].target, TargetState::Unconfigured);
}

TEST(Resumed, no_component_waits_for_results_of_motion_that_does_not_happen) {
  Composition held = robot();
  EXPECT_TRUE(resumed({}, held, "state").components[0].after.empty());
  held.components[1].plan.resume_active = true;
  EXPECT_EQ(resumed({}, held, "state").components[0].after[0].when, launch::When::FirstMessage);
}

TEST(CompositionFile, replaces_the_old_one_whole_and_goes_at_an_orderly_end) {
  const TemporaryFolder folder;
  CompositionFile file{folder.path() + "/robot.composition"};
  ASSERT_TRUE(file.write(robot()));
  Composition less = robot();
  less.components.pop_back();
  ASSERT_TRUE(file.write(less));

  const auto read = read_composition(file.path());

  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read.value(), less);
  EXPECT_FALSE(std::filesystem::exists(file.path() + ".new"));
  file.remove();
  EXPECT_EQ(read_composition(file.path()).value(), std::nullopt);
}

TEST(CompositionFile, reports_a_place_that_cannot_be_written) {
  CompositionFile file{"/proc/nobody/robot.composition"};
  const auto written = file.write(robot());
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().text(), HasSubstr("--state FILE"));
}

}  // namespace
}  // namespace nacelle::session
