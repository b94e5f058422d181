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

/// Loads and unloads components of a running robot. All requests for this pass through it: those of `nacelle
/// component`, of ROS 2's tools, and of components.
///
/// Threads: the main thread creates and destroys it. CompositionHost's members run on the thread of the container's
/// services. They block until the main thread has executed them in serve().
class Loader final : public runtime::CompositionHost {
 public:
  /// Handles the requests of the container's services while it exists. `robot` and its container must outlive this
  /// object.
  explicit Loader(Robot& robot);
  ~Loader() override;

  /// Returns the launch's namespace.
  [[nodiscard]] std::string name_space() const override;
  /// Loads a component of the launch file and brings it to the state that the file requests. Errors: as load().
  [[nodiscard]] Result<Loaded, Problem> load_planned(const std::string& name) override;
  /// Loads a plugin and checks its new wiring. If the request's namespace is relative or empty, the component is placed
  /// below the launch's namespace. It gets the launch's frame prefix and its topics of transforms.
  /// Errors: as Robot::load(); a topic type or QoS that is incompatible with another component's; an activation that
  /// fails; a robot that is not running. On error the component is unloaded.
  [[nodiscard]] Result<Loaded, Problem> load(const runtime::LoadRequest& request, bool activate) override;
  [[nodiscard]] Result<runtime::UnloadOutcome, Problem> unload(std::uint64_t id) override;

  /// Returns a descriptor that is readable when serve() has work to do.
  [[nodiscard]] int descriptor() const { return event_.descriptor(); }
  /// Executes the waiting request.
  void serve();
  /// Refuses the waiting call and all further ones, because the main thread stops serving.
  void close();

 private:
  struct Waiting {
    std::function<void()> call;  // posted by the services' thread, which blocks; at most one
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
