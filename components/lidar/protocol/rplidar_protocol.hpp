// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "lidar/protocol/lidar_protocol.hpp"
#include "lidar/protocol/rplidar_sweeps.hpp"

namespace nacelle::lidar {

/// The RPLIDARs of SLAMTEC: identified, asked for their health and scan modes, started and stopped.
///
///     stop -> info -> health -> scan mode -> motor board -> idle -> motor, scan -> measuring
/// An answer that does not come is asked for again. A device without scan modes (old firmware) has two, Standard and Express. A
/// stream that dries up, or a new line, begins anew with the stop. Deactivation sends the stop and then stops the motor: by the
/// modem line DTR (A1), by PWM (A2, A3 on their board) or by a speed of 0 (S series).
class RplidarProtocol final : public LidarProtocol {
 public:
  /// `scan_mode`: as the device names it, in any case; empty: the one it recommends.
  explicit RplidarProtocol(std::string scan_mode) : scan_mode_(std::move(scan_mode)) {}

  void feed(ByteView bytes, SweepSink& sink) override;
  void restart() override;
  [[nodiscard]] LineStats stats() const override;
  [[nodiscard]] std::size_t pending() const override { return decoder_.pending(); }
  [[nodiscard]] bool is_commanded() const override { return true; }
  void want(bool measuring) override { wanted_ = measuring; }
  [[nodiscard]] std::optional<LineAction> next_action(MonotonicTime now) override;
  [[nodiscard]] bool is_settled() const override { return step_ == (wanted_ ? Step::Measuring : Step::Idle); }
  [[nodiscard]] const std::string& refusal() const override { return refusal_; }
  [[nodiscard]] const std::string& identity() const override { return identity_; }

 private:
  enum class Step : std::uint8_t {
    Stop,      ///< Whatever it does, it shall stop.
    Pause,     ///< The rest of a stream goes by.
    Ask,       ///< The question is to be sent ...
    Wait,      ///< ... or was.
    Idle,      ///< Identified; motor and stream stand.
    Scan,      ///< The motor was started, the scan is to be ...
    Starting,  ///< ... and its first packet is awaited.
    Measuring,
    Halt,       ///< The scan is to be stopped ...
    HaltMotor,  ///< ... then the motor.
    Refused     ///< It cannot be used; asked again after a while.
  };
  enum class Question : std::uint8_t {
    Info,
    Health,
    TypicalMode,
    ModeCount,
    ModeName,
    ModeAnswer,
    ModePeriod,
    SampleRate,
    BoardFlags
  };
  enum class Motor : std::uint8_t { ByModemLine, ByPwm, BySpeed };

  LineAction send(std::uint8_t command, std::initializer_list<std::uint8_t> payload = {});
  LineAction ask();
  void ask_next(Question question);
  void hear(const RplidarPacket& answer);
  void hear_configuration(ByteView value);
  void give_up_question();
  void choose_old_mode();
  void ask_for_motor();
  void finish_identification();
  void refuse(std::string why);
  void pause(MonotonicTime now, Duration length) { until_ = now + length; }
  LineAction drive_motor(bool on);

  const std::string scan_mode_;
  RplidarDecoder decoder_;
  RplidarSweeps sweeps_;
  Step step_ = Step::Stop;
  Question question_ = Question::Info;
  bool wanted_ = false;
  bool heard_ = false;       ///< A measurement came since the last next_action().
  bool motor_runs_ = false;  ///< It was started, and not stopped since.
  bool was_reset_ = false;   ///< Because it said that it protects itself.
  unsigned tries_ = 0;
  MonotonicTime until_{};
  std::array<std::uint8_t, 16> request_{};

  unsigned model_ = 0, firmware_ = 0, hardware_ = 0;
  std::string serial_;
  Motor motor_ = Motor::ByModemLine;
  std::uint16_t mode_ = 0, mode_count_ = 0;
  std::string mode_name_;
  std::vector<std::string> mode_names_;
  RplidarAnswer stream_ = RplidarAnswer::Nodes;
  double period_us_ = 0.0;
  std::string refusal_, identity_;
};

}  // namespace nacelle::lidar
