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

/// Offers the services of the container's node that need a session (nacelle_interfaces, docs/node_interfaces.md):
/// details of a component, faults, statistics, frames, emergency stops, the network, and shutdown.
///
/// Threads: the main thread creates and destroys it. The services answer on another thread, even while the main thread
/// is busy. The services of the network answer in serve().
class InterfaceServices {
 public:
  /// `robot` and everything that it owns must outlive this object.
  explicit InterfaceServices(Robot& robot);
  InterfaceServices(const InterfaceServices&) = delete;
  InterfaceServices& operator=(const InterfaceServices&) = delete;
  ~InterfaceServices() = default;

  /// Returns a descriptor that is readable when serve() has work to do.
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
