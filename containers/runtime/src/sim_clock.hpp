// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

#include "nacelle/base/time.hpp"
#include "nacelle/node/transport.hpp"

namespace nacelle::runtime {

/// The clock of nodes with use_sim_time: ROS time is what /clock said last, and 0 before it says anything, as in rclcpp.
///
/// The monotonic line stays the kernel's: watchdogs and control timeouts must run even while the simulation stands.
/// Threads: as Clock. Allocates: nothing after it was made.
class SimClock final : public Clock, private ReadyListener {
 public:
  SimClock(const Clock& real, Transport& transport);

  [[nodiscard]] MonotonicTime now() const override { return real_.now(); }
  [[nodiscard]] WallTime wall_now() const override {
    return WallTime{Duration{time_ns_.load(std::memory_order_acquire)}};
  }

 private:
  void on_ready() noexcept override;

  const Clock& real_;
  std::atomic<std::int64_t> time_ns_{0};
  std::atomic<Reader*> opened_{nullptr};  // a message may come before the constructor has the reader
  std::unique_ptr<Reader> reader_;        // last: it calls on_ready() until it is gone
};

}  // namespace nacelle::runtime
