// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "answers/robot.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/node/service.hpp"

namespace nacelle::answers {

/// The services of the container's node that only a session can answer (nacelle_interfaces, docs/node_interfaces.md): details of a
/// component, faults, statistics, frames, emergency stops, the network, the end of the robot.
///
/// Threads: made and ended by the main thread. The services answer on another one, also while the main thread is busy; those of the
/// network answer in serve().
class InterfaceServices {
 public:
  /// `robot` and everything that it owns must outlive this.
  explicit InterfaceServices(Robot& robot);
  InterfaceServices(const InterfaceServices&) = delete;
  InterfaceServices& operator=(const InterfaceServices&) = delete;
  ~InterfaceServices() = default;

  /// Readable when serve() has work to do.
  [[nodiscard]] int descriptor() const { return event_.descriptor(); }
  /// Answers the requests that wait for the main thread.
  void serve();

 private:
  template <typename S, typename F>
  void offer(const char* name, F answer);
  template <typename S, typename F>
  void offer_in_serve(const char* name, F answer);
  template <typename S, typename Callback>
  Service<S>& keep(const char* name, Callback callback);

  Robot& robot_;
  Bell event_;
  Guarded<std::vector<std::function<void()>>> waiting_;
  std::vector<std::shared_ptr<void>> services_;
};

}  // namespace nacelle::answers
