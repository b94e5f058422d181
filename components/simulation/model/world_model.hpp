// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "simulation/model/gps_model.hpp"
#include "simulation/model/motor_board.hpp"
#include "simulation/model/paced_line.hpp"
#include "simulation/model/sensor_models.hpp"

namespace nacelle::simulation {

/// The devices of the robot, each on a line of its own.
enum class Device : std::uint8_t { Lidar, Imu, Base, Gps };
inline constexpr std::array kDevices{Device::Lidar, Device::Imu, Device::Base, Device::Gps};
/// "lidar", "imu", "base", "gps": the names of the links.
[[nodiscard]] constexpr std::string_view name_of(Device device) {
  return std::array<std::string_view, kDevices.size()>{"lidar", "imu", "base", "gps"}[static_cast<std::size_t>(device)];
}

/// The robot in its room, with its devices: bytes in, bytes out; times are arguments.
///
/// The same seed, commands and times give the same bytes. Threads: one. Allocates: yes; it lives in a process of its
/// own.
class WorldModel {
 public:
  explicit WorldModel(const WorldSettings& settings);
  WorldModel(const WorldModel&) = delete;  // its parts know each other by address
  WorldModel& operator=(const WorldModel&) = delete;

  /// Bytes that the host wrote to a device. LiDAR and GPS have no receive line.
  void receive(Device device, ByteView bytes);

  /// Moves the world on by one step and calls `deliver(Device, ByteView)` with what its lines carried in it.
  template <typename Deliver>
  void step(Deliver&& deliver) {
    advance();
    for (const Device device : kDevices) {
      line(device).release(now_, [&](ByteView bytes) { deliver(device, bytes); });
    }
  }

  [[nodiscard]] Duration now() const { return now_; }
  [[nodiscard]] const DriveModel& drive() const { return drive_; }
  [[nodiscard]] const MotorBoard& board() const { return board_; }
  [[nodiscard]] const ImuModel& imu() const { return imu_; }
  [[nodiscard]] const WorldSettings& settings() const { return settings_; }

  static constexpr Duration kStep = 1ms;
  static constexpr unsigned kLidarBaud = 230400, kImuBaud = 115200, kBaseBaud = 115200, kGpsBaud = 38400;

 private:
  void advance();
  void send_imu_sample();
  void send_feedback();
  [[nodiscard]] PacedLine& line(Device device) { return lines_[static_cast<std::size_t>(device)]; }

  const WorldSettings settings_;
  const Room room_;
  DriveModel drive_;
  MotorBoard board_;
  LidarModel lidar_;
  ImuModel imu_;
  Wt901Registers imu_registers_;
  UgvLineReader base_reader_;
  GpsModel gps_;
  std::array<PacedLine, kDevices.size()> lines_{PacedLine{kLidarBaud}, PacedLine{kImuBaud}, PacedLine{kBaseBaud},
                                                PacedLine{kGpsBaud}};
  Duration now_{};
  Duration next_imu_sample_{};
  Duration next_fix_{};
  Duration last_feedback_{};
};

}  // namespace nacelle::simulation
