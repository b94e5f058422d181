// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <memory>

#include "diff_drive/model/count_rate.hpp"
#include "diff_drive/model/wheel_pid.hpp"
#include "diff_drive/port/base_port.hpp"
#include "diff_drive/port/h_bridges.hpp"
#include "diff_drive/port/wheel_encoders.hpp"

namespace nacelle::diff_drive {

/// A base whose motors this computer drives itself: by PWM and direction lines, with encoders that it reads.
///
/// write() reads the encoders, runs the controllers of both wheels, and sets the outputs. read_until() hands over one state, when its deadline
/// comes: the control loop's instant, so the controllers see what the state says. A wheel that stands or turns the wrong way at its full output for
/// Settings::stall_limit_s is a fault of the board (on_board_fault()), which is over kFaultHold later.
/// There is no other controller that would stop the wheels in this program's place: see stop_frame() and further_descriptors().
/// Threads: as BasePort. Allocates: nothing but in reopen().
class PwmBasePort final : public BasePort {
 public:
  struct Wheel {
    bool is_reversed = false;          ///< The motor and its encoder are mounted the other way round.
    bool encoder_is_reversed = false;  ///< The encoder counts the other way than its motor turns.
  };
  struct Settings {
    Wheel left, right;
    double counts_per_turn = 1.0;
    double max_wheel_rate_rps = 100.0;
    WheelPidSettings pid;
    double min_duty = 0.0;  ///< Below this the motors do not turn.
    double max_duty = 1.0;
    double stall_limit_s = 1.0;  ///< 0: wheels are not watched.
  };
  /// Waits until then; tests move their clock instead.
  using Wait = std::function<void(MonotonicTime until)>;

  PwmBasePort(std::unique_ptr<HBridges> motors, std::unique_ptr<WheelEncoders> encoders, const Clock& clock,
              const Settings& settings, Wait wait = {});

  [[nodiscard]] Result<void, BaseFault> start() override;
  [[nodiscard]] Result<void, BaseFault> read_until(MonotonicTime deadline, WheelStateSink& sink) override;
  [[nodiscard]] Result<void, BaseFault> write(const WheelRates& rates) override;
  [[nodiscard]] Result<void, BaseFault> stop() override;
  [[nodiscard]] Result<void, BaseFault> reopen() override;
  void rest_until(MonotonicTime deadline) override;
  void interrupt() noexcept override { bell_.ring(); }

  [[nodiscard]] double max_wheel_rate() const override { return settings_.max_wheel_rate_rps; }
  [[nodiscard]] ByteView stop_frame() const override { return PwmChannel::kStop; }
  [[nodiscard]] int descriptor() const noexcept override { return motors_->descriptors().front(); }
  [[nodiscard]] std::span<const int> further_descriptors() const noexcept override {
    return motors_->descriptors().subspan(1);
  }
  [[nodiscard]] Stats stats() const override;

  static constexpr Duration kFaultHold = 1s;

 private:
  struct Side {
    Side(const Wheel& wheel, const Settings& settings);

    const double motor_sign;
    const double rad_per_count;  // with the sign of forward
    WheelPid pid;
    WheelWatch watch;
    CountRate rate;
    WheelCount counted;
    double rate_rps = 0.0;
    double angle_rad = 0.0;
    double output = 0.0;
    WheelWatch::Finding finding = WheelWatch::Finding::None;
  };

  [[nodiscard]] Result<void, BaseFault> sample();
  void control(Side& side, double wanted_rps, double dt_s) const;
  [[nodiscard]] double share_of(const Side& side) const;
  void report_faults(MonotonicTime now, WheelStateSink& sink);
  void forget();

  const std::unique_ptr<HBridges> motors_;
  const std::unique_ptr<WheelEncoders> encoders_;
  const Clock& clock_;
  const Settings settings_;
  const Wait wait_;
  Bell bell_;
  bool was_woken_ = false;
  std::array<Side, 2> sides_;
  MonotonicTime sampled_at_{}, controlled_at_{};
  bool is_stopped_ = true;
  const char* fault_ = nullptr;
  MonotonicTime fault_at_{};
  Stats stats_;
};

}  // namespace nacelle::diff_drive
