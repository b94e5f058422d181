// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>

#include "diff_drive/port/base_port.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::diff_drive {

/// A base without hardware: its wheels turn exactly as commanded.
///
/// States come at a fixed period of the given clock. `wait` ends a wait early in tests, which do not sleep: it is
/// called with the time until which the port would have slept, and moves the test's clock.
class LoopbackPort final : public BasePort {
 public:
  struct Settings {
    Duration state_period = 20ms;
    double voltage_v = 12.0;
  };
  using Wait = std::function<void(MonotonicTime until)>;

  LoopbackPort(const Clock& clock, Settings settings, Wait wait = {});

  [[nodiscard]] Result<void, BaseFault> start() override;
  [[nodiscard]] Result<void, BaseFault> read_until(MonotonicTime deadline, WheelStateSink& sink) override;
  [[nodiscard]] Result<void, BaseFault> write(const WheelRates& rates) override;
  [[nodiscard]] Result<void, BaseFault> stop() override { return write({}); }
  void rest_until(MonotonicTime deadline) override;
  void interrupt() noexcept override { bell_.ring(); }

  [[nodiscard]] double max_wheel_rate() const override { return std::numeric_limits<double>::infinity(); }
  [[nodiscard]] ByteView stop_frame() const override { return {}; }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  [[nodiscard]] Stats stats() const override { return stats_; }

 private:
  void turn_wheels_until(MonotonicTime now);

  const Clock& clock_;
  const Settings settings_;
  const Wait wait_;
  Bell bell_;
  WheelState wheels_;
  MonotonicTime next_state_{};
  Stats stats_;
};

}  // namespace nacelle::diff_drive
