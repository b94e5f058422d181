// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "nacelle/host/node_host.hpp"

namespace nacelle {

/// Runs a callback on the component's executor when any thread asks for it. Several asks may share one run.
///
/// It runs behind a closed lifecycle gate, too.
class WakeUp {
 public:
  using SharedPtr = std::shared_ptr<WakeUp>;
  virtual ~WakeUp() = default;
  /// Threads: any, with locks held.
  void wake() noexcept { handle_->listener().on_status(); }

 protected:
  std::unique_ptr<StatusEventHandle> handle_;
};

namespace detail {

template <typename F>
class CallbackWakeUp final : public WakeUp {
 public:
  explicit CallbackWakeUp(F callback) : callback_(std::move(callback)) {}
  ~CallbackWakeUp() override { handle_.reset(); }
  void attach(std::unique_ptr<StatusEventHandle> handle) { handle_ = std::move(handle); }
  static void run(void* context) { static_cast<CallbackWakeUp*>(context)->callback_(); }

 private:
  F callback_;
};

}  // namespace detail
}  // namespace nacelle
