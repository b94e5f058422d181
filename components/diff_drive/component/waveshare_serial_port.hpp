// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>

#include "diff_drive/port/base_port.hpp"
#include "diff_drive/protocol/waveshare_command.hpp"
#include "diff_drive/protocol/waveshare_feedback.hpp"
#include "nacelle/io/byte_stream.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::diff_drive {

/// A base behind a Waveshare UGV board: joins the board's JSON lines to a serial line.
///
/// It stands in component/ and not in port/, because it is where protocol and port meet.
/// The board speaks of the wheel's rim in m/s and m; the radius it is given turns them into rad.
/// Commands do not queue: the newest replaces one that has not left the line yet, and a stop goes before all that waits.
class WaveshareSerialPort final : public BasePort {
 public:
  struct Settings {
    double wheel_radius_m = 0.033;                  ///< As configured in the board. Must be positive.
    std::chrono::milliseconds motor_watchdog{500};  ///< The board stops after this silence of ours; 0 leaves its 3 s.
    /// Transmission time of a byte. The board reads its wheels, then sends, so a state is as old as its line takes to transmit
    /// (16 ms at 115200 baud). Zero: states are stamped when they are read.
    Duration byte_time{};
  };

  WaveshareSerialPort(std::unique_ptr<io::ByteStream> line, const Clock& clock, Settings settings);

  [[nodiscard]] Result<void, BaseFault> start() override;
  [[nodiscard]] Result<void, BaseFault> read_until(MonotonicTime deadline, WheelStateSink& sink) override;
  [[nodiscard]] Result<void, BaseFault> write(const WheelRates& rates) override;
  [[nodiscard]] Result<void, BaseFault> stop() override;
  [[nodiscard]] Result<void, BaseFault> reopen() override;
  void rest_until(MonotonicTime deadline) override;
  void interrupt() noexcept override {
    bell_.ring();
    line_->interrupt();
  }

  [[nodiscard]] double max_wheel_rate() const override {
    return kWaveshareMaxWheelSpeed_mps / settings_.wheel_radius_m;
  }
  [[nodiscard]] ByteView stop_frame() const override { return kWaveshareStopFrame; }
  [[nodiscard]] int descriptor() const noexcept override { return line_->descriptor(); }
  [[nodiscard]] Stats stats() const override;

 private:
  /// The wheels' rims as the board counts them, made continuous.
  struct Travel {
    double left_m = 0.0, right_m = 0.0;
  };

  [[nodiscard]] Result<void, BaseFault> send(ByteView frame);
  [[nodiscard]] Result<void, BaseFault> send_speed(ByteView frame);
  void drop_unsent();
  [[nodiscard]] WheelState to_wheel_state(const BaseFeedback& feedback, MonotonicTime captured_at);
  [[nodiscard]] MonotonicTime capture_time(MonotonicTime received_at, std::uint64_t chunk_end);
  void advance(const BaseFeedback& feedback, MonotonicTime captured_at);

  std::unique_ptr<io::ByteStream> line_;
  Bell bell_;  // of rest_until(): a lost line does not wake it
  const Clock& clock_;
  const Settings settings_;
  WaveshareCommandPrinter printer_;
  WaveshareLineDecoder decoder_;
  bool line_torn_ = false;   // a command was sent in part: the next one must not continue it
  bool is_stopped_ = false;  // a stop was the last speed that was sent
  MonotonicTime gone_by_{};  // when all sent bytes have left the line, if it takes any
  bool has_state_ = false;
  Travel board_;  // as last reported by the board
  Travel total_;  // accumulated
  MonotonicTime last_at_{};
  std::uint64_t told_bytes_ = 0;  // of all feedback lines so far
  Stats stats_;
};

}  // namespace nacelle::diff_drive
