// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/port/base_port.hpp"
#include "nacelle/io/byte_stream.hpp"
#include "nacelle/io/descriptor.hpp"
#include "nacelle/io/line_signature.hpp"

namespace nacelle::diff_drive {

/// A base behind a motor board on a serial line, or boards on a CAN bus: joins a MotorBoard to a ByteStream.
///
/// It stands in component/ and not in port/, because it is where protocol and port meet.
/// Commands do not queue: the newest replaces one that has not left the line yet, and a stop goes before all that waits.
class SerialBasePort final : public BasePort, private BoardEars {
 public:
  struct Settings {
    /// Transmission time of a byte. A board reads its wheels, then sends, so a state is as old as its frame takes to transmit
    /// (16 ms for a Waveshare board at 115200 baud). Zero: states are stamped when they are read.
    Duration byte_time{};
    double max_wheel_rate_rps = 100.0;  ///< Of the wheels; the board's own limit counts too.
    double restart_slack_rad = 3.0;     ///< WheelTravel::Settings::slack_rad.
    /// What is on the line, for why_no_state(). Empty: its bytes are not looked at (a CAN bus, which carries others' frames).
    std::optional<io::ExpectedDevice> expected{};
  };

  SerialBasePort(std::unique_ptr<io::ByteStream> line, std::unique_ptr<MotorBoard> board, const Clock& clock,
                 const Settings& settings);

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

  [[nodiscard]] double max_wheel_rate() const override;
  [[nodiscard]] ByteView stop_frame() const override { return {safe_stop_.data(), safe_stop_bytes_}; }
  [[nodiscard]] int descriptor() const noexcept override { return line_->descriptor(); }
  [[nodiscard]] Stats stats() const override;
  [[nodiscard]] std::string why_no_state(Duration waited) const override;

 private:
  void on_wheels(const WheelReading& reading, std::uint64_t first_byte) override;
  void on_voltage(double voltage_v) override { voltage_v_ = voltage_v; }
  void on_fault(const char* fault) override;

  void feed(ByteView bytes, BoardEars& ears);
  [[nodiscard]] Result<void, BaseFault> send(ByteView frame);
  [[nodiscard]] Result<void, BaseFault> send_command(ByteView frame, const WheelRates& rates, bool is_stop);
  [[nodiscard]] Result<void, BaseFault> send_requests();
  void drop_unsent();

  std::unique_ptr<io::ByteStream> line_;
  std::unique_ptr<MotorBoard> board_;
  Bell bell_;  // of rest_until(): a lost line does not wake it
  const Clock& clock_;
  const Settings settings_;
  bool line_torn_ = false;                    // a frame was sent in part: the next one must not continue it
  bool is_stopped_ = false;                   // a stop was the last command that was sent
  bool is_stuck_ = false;                     // the line took no bytes in time: no requests wait behind the command
  MonotonicTime gone_by_{};                   // when all sent bytes have left the line, if it takes any
  std::array<std::uint8_t, 64> safe_stop_{};  // a stop that is understood behind half a frame
  std::size_t safe_stop_bytes_ = 0;
  WheelTravel travel_;
  std::optional<double> voltage_v_;
  Stats stats_;
  io::HeardOnLine heard_;          // since the line was opened
  std::uint64_t lost_before_ = 0;  // bytes that the board's decoder could not use by then

  // Of the chunk that is being decoded.
  WheelStateSink* sink_ = nullptr;
  MonotonicTime received_at_{};
  std::uint64_t chunk_end_ = 0;
};

}  // namespace nacelle::diff_drive
