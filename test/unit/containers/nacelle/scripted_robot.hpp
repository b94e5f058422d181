// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "benchmark/support/recipe.hpp"
#include "loading/load_request.hpp"
#include "nacelle/base/bytes.hpp"
#include "support/manual_clock.hpp"
#include "support/places.hpp"

namespace nacelle::test {

/// A component that follows the script of a test. The container loads it like any other; a parameter carries its address.
class ScriptedComponent final : public bench::Recipe {
 public:
  /// An actuator has a stop frame, which goes to `stop_line`.
  explicit ScriptedComponent(int stop_line = -1) : stop_line_(stop_line) {}
  std::shared_ptr<void> build(LifecycleNode& made) override {
    if (fails_to_load) throw std::runtime_error{"its device is gone"};
    ++loads;
    node = &made;
    if (on_load) on_load();
    static constexpr std::array<std::uint8_t, 1> kStop{'s'};
    if (stop_line_ >= 0) made.register_safe_stop(stop_line_, kStop);
    return nullptr;
  }
  std::function<std::string(Transition)> on_transition() override {
    return [this](Transition transition) { return script ? script(transition) : ""; };
  }
  /// As a launch file would say it.
  [[nodiscard]] launch::ComponentPlan plan(const std::string& name) const {
    launch::ComponentPlan plan;
    plan.plugin = "nacelle::bench::Part";
    plan.name = name;
    plan.namespace_ = "/";
    plan.parameters = {parameter()};
    return plan;
  }
  [[nodiscard]] launch::Parameter parameter() const {
    return {.name = "recipe", .value = static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(this))};
  }
  std::function<void()> on_load;
  std::function<std::string(Transition)> script;  ///< Returns why a transition fails.
  LifecycleNode* node = nullptr;                  ///< Of the last load.
  int loads = 0;
  bool fails_to_load = false;

 private:
  const int stop_line_;
};

/// A robot with scripted components, a manual clock and a real container.
class ScriptedRobot final : public answers::Robot {
 public:
  ScriptedRobot() : container_(options(), clock_) { plan_.container.name = "robot"; }

  /// Adds it to the plan, loads it and takes it to its target.
  runtime::ComponentInfo start(const std::string& name, const ScriptedComponent& component,
                               const FaultHandling& on_fault = {},
                               launch::TargetState target = launch::TargetState::Active) {
    launch::ComponentPlan plan = component.plan(name);
    plan.on_fault = on_fault;
    plan.target = target;
    plan_.components.push_back(plan);
    auto loaded = load(plan);
    EXPECT_TRUE(loaded) << loaded.error().text();
    const auto up = bring_to(loaded.value(), target);
    EXPECT_TRUE(up) << up.error().text();
    return loaded.value();
  }
  [[nodiscard]] runtime::ComponentInfo find(const std::string& node) const {
    const auto found = container_.find(node);
    return found ? found.value() : runtime::ComponentInfo{};
  }

  const std::string& name() const override { return container_.options().name; }
  answers::Phase phase() const override { return phase_; }
  runtime::Container& container() override { return container_; }
  const launch::Plan& plan() const override { return plan_; }
  networking::Network& network() override { throw std::logic_error{"a scripted robot has no network"}; }
  const std::vector<std::filesystem::path>& message_folders() const override { return message_folders_; }
  nacelle_interfaces::srv::GetFaults::Response faults() const override { return {}; }
  std::vector<std::string> emergency_stops() const override { return emergency_stops_; }
  Result<std::vector<answers::ReleasedStop>, Problem> release_emergency_stops(
      const std::vector<std::string>& /*topics*/) override {
    return std::vector<answers::ReleasedStop>{};
  }
  using Robot::load;
  Result<runtime::ComponentInfo, Problem> load(const launch::ComponentPlan& component,
                                               const std::shared_ptr<ParameterFaults>& /*faults*/) override {
    return container_.load(loading::load_request_of(component));
  }
  void composition_changed() override { ++changes_; }
  void request_shutdown() override { is_to_end_ = true; }

  ManualClock clock_;
  launch::Plan plan_;
  answers::Phase phase_ = answers::Phase::Running;
  std::vector<std::string> emergency_stops_;
  int changes_ = 0;
  bool is_to_end_ = false;

 private:
  static runtime::ContainerOptions options() {
    runtime::ContainerOptions options;
    options.name = "robot";
    options.component_path = {test::component_folder()};
    return options;
  }
  runtime::Container container_;
  std::vector<std::filesystem::path> message_folders_;
};

}  // namespace nacelle::test
