// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "nacelle/host/node_host.hpp"

namespace nacelle {

/// Calls back at a fixed period of the monotonic clock, on the component's executor.
///
/// One of Node::create_timer() in a node with use_sim_time counts /clock instead: it stands while that stands, starts with the
/// first time that comes, and after a jump back ticks a full period later (rcl's rules).
///
/// A late tick is not made up for: the next one is due at the next multiple of the period. Silent while a lifecycle node is
/// not active. The first tick comes a full period after creation. If that is unobservable (in a constructor, behind
/// a closed lifecycle gate), timers of up to one second join the common beat of their period, at most one period later.
class Timer {
 public:
  using SharedPtr = std::shared_ptr<Timer>;
  virtual ~Timer() = default;
  void cancel() { handle_->cancel(); }
  /// Starts a full period from now; also ends a cancel().
  void reset() { handle_->reset(); }
  [[nodiscard]] bool is_canceled() const { return handle_->is_canceled(); }

 protected:
  std::unique_ptr<TimerHandle> handle_;
};

namespace detail {

template <typename F>
class CallbackTimer final : public Timer {
 public:
  explicit CallbackTimer(F callback) : callback_(std::move(callback)) {}
  ~CallbackTimer() override { handle_.reset(); }
  void attach(std::unique_ptr<TimerHandle> handle) { handle_ = std::move(handle); }
  static void run(void* context) { static_cast<CallbackTimer*>(context)->callback_(); }

 private:
  F callback_;
};

}  // namespace detail
}  // namespace nacelle
