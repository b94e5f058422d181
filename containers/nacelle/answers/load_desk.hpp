// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "answers/robot.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/composition_host.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::answers {

/// The one way in which components of a running robot come and go: what the services of the container's node are asked for,
/// by `nacelle component`, by ROS 2's tools and by components.
///
/// Threads: made and ended by the main thread; CompositionHost's members on the thread of the container's services, where they wait
/// until the main thread has carried them out in serve().
class LoadDesk final : public runtime::CompositionHost {
 public:
  /// Answers for the services of the session's container as long as it lives. `robot` and its container outlive this.
  explicit LoadDesk(Robot& robot);
  ~LoadDesk() override;

  /// The launch's.
  [[nodiscard]] std::string name_space() const override;
  /// Takes it to the state that the launch file gives. Errors: as load().
  [[nodiscard]] Result<Loaded, Problem> load_planned(const std::string& name) override;
  /// Loads a plugin into the launch's namespace: below it if the request's namespace is relative or empty, with its frame prefix and
  /// its topics of transforms. Checks the new wiring.
  /// Errors: as Robot::load(); its QoS does not fit a component's; it does not become active; the robot is not up. Nothing of it is
  /// left then.
  [[nodiscard]] Result<Loaded, Problem> load(const runtime::LoadRequest& request, bool activate) override;
  [[nodiscard]] Result<runtime::UnloadOutcome, Problem> unload(std::uint64_t id) override;

  /// Readable when serve() has something to do.
  [[nodiscard]] int descriptor() const { return event_.descriptor(); }
  /// Carries out what a service was asked for.
  void serve();
  /// Refuses the call that waits, and all that follow: the main thread serves no more.
  void close();

 private:
  struct Waiting {
    std::function<void()> call;  // of the services' thread, which waits; it has one at most
    bool closed = false;
  };

  [[nodiscard]] Result<Loaded, Problem> load_planned_now(const std::string& name);
  [[nodiscard]] Result<Loaded, Problem> load_now(runtime::LoadRequest request, launch::TargetState target);
  [[nodiscard]] Result<Loaded, Problem> finish(Loaded loaded, launch::TargetState target);
  template <typename Act>
  [[nodiscard]] auto on_main_thread(Act act) -> decltype(act());
  [[nodiscard]] Problem not_running() const;

  Robot& robot_;
  Bell event_;
  Guarded<Waiting> waiting_;
};

}  // namespace nacelle::answers
