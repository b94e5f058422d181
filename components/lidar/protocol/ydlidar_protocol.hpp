// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lidar/protocol/lidar_protocol.hpp"
#include "lidar/protocol/rotor_offset.hpp"
#include "lidar/protocol/rplidar_decoder.hpp"
#include "lidar/protocol/ydlidar_decoder.hpp"

namespace nacelle::lidar {

/// The triangulating YDLIDARs. The X2 only sends; the X4 and the G series are identified, asked for their health, started and
/// stopped, in the words of an RPLIDAR. The motor of an X4 stands while its board's DTR is off.
class YdlidarProtocol final : public LidarProtocol {
 public:
  struct Settings {
    unsigned points_per_second = 3000;
    bool has_intensities = false;
    bool is_commanded = false;
  };
  explicit YdlidarProtocol(const Settings& settings);

  void feed(ByteView bytes, SweepSink& sink) override;
  void restart() override;
  [[nodiscard]] LineStats stats() const override;
  [[nodiscard]] std::size_t pending() const override { return packets_.pending() + answers_.pending(); }
  [[nodiscard]] bool knows_its_rate() const override { return false; }
  [[nodiscard]] bool is_commanded() const override { return is_commanded_; }
  void want(bool measuring) override { wanted_ = measuring; }
  [[nodiscard]] std::optional<LineAction> next_action(MonotonicTime now) override;
  [[nodiscard]] bool is_settled() const override;
  [[nodiscard]] const std::string& refusal() const override { return refusal_; }
  [[nodiscard]] const std::string& identity() const override { return identity_; }

 private:
  enum class Step : std::uint8_t {
    Stop,       ///< Whatever it does, it shall stop.
    Pause,      ///< The rest of a stream goes by.
    Info,       ///< Its answer is awaited ...
    Health,     ///< ... then this one.
    Idle,       ///< Identified; motor and stream stand.
    Scan,       ///< The motor was started, the scan is to be.
    Running,    ///< Packets are expected.
    HaltMotor,  ///< The scan was stopped, the motor is to be.
    Refused     ///< It cannot be used; asked again after a while.
  };
  void measure(const YdlidarPacket& packet, std::size_t bytes_after, SweepSink& sink);
  void hear(const RplidarPacket& answer);
  LineAction send(std::uint8_t command);

  const Duration period_;
  const bool has_intensities_, is_commanded_;
  YdlidarDecoder packets_;
  RplidarDecoder answers_;  ///< Gets the bytes while no packets are expected.
  RotorOffset offset_{7.5};
  double last_deg_ = -1.0;  ///< Of the last packet's last sample; negative: none.
  double step_deg_ = 0.0;   ///< From sample to sample; 0: unknown.
  std::array<Beam, ydlidar_layout::kMostSamples> beams_{};

  Step step_ = Step::Stop;
  bool wanted_ = false, heard_ = false, measures_ = false;
  bool motor_runs_ = false;  ///< It was started, and not stopped since.
  MonotonicTime until_{};
  std::array<std::uint8_t, 2> request_{};
  std::string refusal_, identity_;
};

}  // namespace nacelle::lidar
