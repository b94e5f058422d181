// SPDX-License-Identifier: Apache-2.0
#include "answers/loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <future>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/string.hpp>

#include "answers/robot_fault.hpp"
#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/name_fault.hpp"
#include "unit/containers/nacelle/scripted_robot.hpp"

namespace nacelle::answers {
namespace {

using std_msgs::msg::String;
using ::testing::HasSubstr;

class LoaderTest : public ::testing::Test {
 protected:
  using Loaded = Loader::Loaded;

  /// Asks as the thread of the container's services does, and serves as the main thread does.
  template <typename Ask>
  auto ask(Ask what) {
    auto answer = std::async(std::launch::async, std::move(what));
    pollfd wait{loader_.descriptor(), POLLIN, 0};
    EXPECT_EQ(::poll(&wait, 1, 20'000), 1) << "only a broken loader takes so long";
    loader_.serve();
    return answer.get();
  }
  Result<Loaded, Problem> load(const test::ScriptedComponent& component, const std::string& name,
                               bool activate = true) {
    runtime::LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.parameters[component.parameter().name] = component.parameter().value;
    return ask([=, this] { return loader_.load(request, activate); });
  }

  test::ScriptedComponent lidar_;
  test::ScriptedRobot robot_;
  Loader loader_{robot_};
};

TEST_F(LoaderTest, loads_a_plugin_and_takes_it_to_the_state_that_is_asked_for) {
  const auto active = load(lidar_, "lidar");
  ASSERT_TRUE(active) << active.error().text();
  EXPECT_EQ(active.value().component.state, StateId::Active);
  const auto waiting = load(lidar_, "other", false);
  ASSERT_TRUE(waiting) << waiting.error().text();
  EXPECT_EQ(waiting.value().component.state, StateId::Unconfigured);
  EXPECT_EQ(robot_.changes_, 2) << "the composition is kept after each";
}

TEST_F(LoaderTest, loads_below_the_namespace_of_the_launch) {
  robot_.plan_.name_space.path = "/robot1";
  const auto loaded = load(lidar_, "lidar");
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(loaded.value().component.node, "/robot1/lidar");
}

TEST_F(LoaderTest, takes_out_again_what_does_not_become_active) {
  lidar_.script = [](Transition to) { return to == Transition::Activate ? "no such device" : ""; };
  const auto loaded = load(lidar_, "lidar");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, LifecycleFault::TransitionFailed);
  EXPECT_EQ(loaded.error().where, Place("/lidar"));
  EXPECT_EQ(loaded.error().value, "activate");
  EXPECT_EQ(loaded.error().text(), "/lidar: could not activate: no such device; it was unloaded again");
  EXPECT_EQ(robot_.find("/lidar").node, "");
}

TEST_F(LoaderTest, takes_out_again_what_cannot_talk_to_a_component_that_is_there) {
  struct Reader : bench::Recipe {
    std::shared_ptr<void> build(LifecycleNode& node) override {
      return node.create_subscription<String>("text", QoS(1), [](const String&) {});
    }
  } reader;
  struct Writer : bench::Recipe {
    std::shared_ptr<void> build(LifecycleNode& node) override {
      return node.create_publisher<String>("text", QoS(1).best_effort());
    }
  } writer;
  struct WriterOfAnotherType : bench::Recipe {
    std::shared_ptr<void> build(LifecycleNode& node) override {
      return node.create_publisher<std_msgs::msg::Bool>("text", QoS(1));
    }
  } other;
  const auto load_recipe = [this](bench::Recipe& recipe, const std::string& name) {
    runtime::LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.parameters["recipe"] = static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe));
    return ask([=, this] { return loader_.load(request, true); });
  };
  ASSERT_TRUE(load_recipe(reader, "reader"));
  const auto loaded = load_recipe(writer, "writer");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, RobotFault::QosMismatch);
  EXPECT_EQ(loaded.error().where, Place("/writer"));
  EXPECT_EQ(loaded.error().value, "/text");
  EXPECT_THAT(loaded.error().text(),
              HasSubstr("/text: /writer publishes with reliability best_effort, /reader asks for reliable"));
  EXPECT_EQ(robot_.find("/writer").node, "");

  const auto of_another_type = load_recipe(other, "other");
  ASSERT_FALSE(of_another_type);
  EXPECT_EQ(of_another_type.error().code, RobotFault::TopicTypes);
  EXPECT_EQ(of_another_type.error().value, "/text");
  EXPECT_THAT(of_another_type.error().text(), HasSubstr("/other publishes std_msgs/msg/Bool"));
  EXPECT_EQ(robot_.find("/other").node, "");
  EXPECT_EQ(robot_.find("/reader").state, StateId::Active);
}

TEST_F(LoaderTest, loads_what_the_launch_file_names_to_the_state_that_it_gives) {
  robot_.plan_.components.push_back(lidar_.plan("lidar"));
  robot_.plan_.components.back().target = launch::TargetState::Inactive;
  const auto loaded = ask([this] { return loader_.load_planned("lidar"); });
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(loaded.value().component.state, StateId::Inactive);
  const auto unknown = ask([this] { return loader_.load_planned("lidr"); });
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, NameFault::Unknown);
  EXPECT_EQ(unknown.error().value, "lidr");
  EXPECT_EQ(
      unknown.error().text(),
      "component lidr: the launch file has no component of that name; did you mean 'lidar'?; a plugin is loaded with "
      "its class and --name");
}

TEST_F(LoaderTest, unloads_by_id) {
  const auto loaded = load(lidar_, "lidar");
  ASSERT_TRUE(loaded) << loaded.error().text();
  const auto out = ask([&] { return loader_.unload(loaded.value().component.id); });
  EXPECT_TRUE(out) << out.error().text();
  EXPECT_EQ(robot_.find("/lidar").node, "");
}

TEST_F(LoaderTest, refuses_while_the_robot_is_not_running) {
  robot_.phase_ = Phase::Starting;
  const auto loaded = loader_.load({}, true);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, RobotFault::NotRunning);
  EXPECT_EQ(loaded.error().where, Place("container robot"));
  EXPECT_EQ(loaded.error().value, "starting");
  EXPECT_EQ(loaded.error().text(), "container robot: it is starting; try again when it is running");
}

TEST_F(LoaderTest, refuses_the_call_that_waits_when_it_is_closed_and_all_that_follow) {
  auto waiting = std::async(std::launch::async, [this] { return loader_.unload(1); });
  pollfd wait{loader_.descriptor(), POLLIN, 0};
  ASSERT_EQ(::poll(&wait, 1, 20'000), 1);
  loader_.close();
  for (const auto& refused : {waiting.get(), loader_.unload(1)}) {
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, RobotFault::NotRunning);
  }
}

}  // namespace
}  // namespace nacelle::answers
