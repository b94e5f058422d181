// SPDX-License-Identifier: Apache-2.0
// The emulators of components/simulation that are no SerialDevice by themselves, at the ends of their lines.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "simulation/model/motor_board.hpp"
#include "simulation/model/serial_device.hpp"
#include "simulation/protocol/motor_device.hpp"
#include "simulation/protocol/nmea_receiver.hpp"
#include "simulation/protocol/st_and_bosch_chips.hpp"
#include "simulation/protocol/ugv_device.hpp"
#include "simulation/protocol/wt901_device.hpp"

namespace nacelle::test {

/// A motor board whose wheels turn as commanded.
class BoardOnALine final : public simulation::SerialDevice {
 public:
  BoardOnALine(std::unique_ptr<simulation::MotorDevice> board, unsigned baud) : board_(std::move(board)), baud_(baud) {}
  [[nodiscard]] unsigned baud() const override { return baud_; }
  void receive(ByteView bytes, Duration now) override { answer_ = board_->on_bytes(bytes, now); }
  void advance(Duration now, const Send& send) override {
    if (const Bytes answer = std::exchange(answer_, {}); !answer.empty()) send(now, answer);
    for (; next_ <= now; next_ += kStep) {
      left_rad_ += to_seconds(kStep) * board_->left_target_rps();
      right_rad_ += to_seconds(kStep) * board_->right_target_rps();
      if (const Bytes bytes = board_->step(next_, left_rad_, right_rad_); !bytes.empty()) send(next_, bytes);
    }
  }

 private:
  static constexpr Duration kStep = 10ms;
  const std::unique_ptr<simulation::MotorDevice> board_;
  const unsigned baud_;
  Bytes answer_;
  Duration next_ = kStep;
  double left_rad_ = 0.0, right_rad_ = 0.0;
};

/// A Waveshare UGV board, as the simulated robot has it.
class UgvOnALine final : public simulation::SerialDevice {
 public:
  [[nodiscard]] unsigned baud() const override { return 115200; }
  void receive(ByteView bytes, Duration now) override {
    reader_.feed(bytes,
                 [&](const simulation::UgvCommand& command, std::string_view) { board_.on_command(command, now); });
  }
  void advance(Duration now, const Send& send) override {
    for (; next_ <= now; next_ += kFeedback) {
      board_.step(next_, 0.0, 0.0);
      if (!board_.feedback_flows()) continue;
      simulation::UgvFeedback feedback;
      board_.describe(feedback);
      send(next_, as_bytes(print_feedback(feedback)));
    }
  }

 private:
  static constexpr Duration kFeedback = 20ms;  // a line of 180 bytes takes 16 ms
  simulation::UgvLineReader reader_;
  simulation::MotorBoard board_{simulation::RobotNominal{}};
  Duration next_ = kFeedback;
};

/// A WT901 at rest, as it leaves a robot's first set-up.
class Wt901OnALine final : public simulation::SerialDevice {
 public:
  /// `samples` counts those that were sent.
  explicit Wt901OnALine(std::atomic<std::uint64_t>* samples = nullptr) : samples_(samples) {}
  [[nodiscard]] unsigned baud() const override { return 115200; }
  void receive(ByteView bytes, Duration now) override { registers_.feed(bytes, to_seconds(now)); }
  void advance(Duration now, const Send& send) override {
    simulation::Wt901Reading reading;
    reading.acceleration_g = {0.0, 0.0, 1.0};
    for (; next_ <= now; next_ += from_seconds(1.0 / registers_.rate_hz())) {
      if (samples_ != nullptr) ++*samples_;
      for (const std::uint8_t type : {0x51, 0x52, 0x53, 0x54, 0x59})
        if ((registers_.mask() >> (type - 0x50U) & 1U) != 0) send(next_, print_wt901(type, reading));
    }
  }

 private:
  std::atomic<std::uint64_t>* const samples_;
  simulation::Wt901Registers registers_;
  Duration next_ = 10ms;
};

/// A BNO08x in the mode UART-RVC.
class RvcOnALine final : public simulation::SerialDevice {
 public:
  [[nodiscard]] unsigned baud() const override { return 115200; }
  void advance(Duration now, const Send& send) override {
    for (; next_ <= now; next_ += 10ms) send(next_, simulation::print_rvc(index_++, {90.0, 0.0, 0.0}, {0.0, 0.0, 1.0}));
  }

 private:
  std::uint8_t index_ = 0;
  Duration next_ = 10ms;
};

/// A BNO055 that is asked over its serial line.
class Bno055OnALine final : public simulation::SerialDevice {
 public:
  [[nodiscard]] unsigned baud() const override { return 115200; }
  void receive(ByteView bytes, Duration) override { answer_ = chip_.serial(bytes); }
  void advance(Duration now, const Send& send) override {
    chip_.advance(to_seconds(now - std::exchange(last_, now)), {});
    if (const Bytes answer = std::exchange(answer_, {}); !answer.empty()) send(now, answer);
  }

 private:
  simulation::Bno055Chip chip_;
  Bytes answer_;
  Duration last_{};
};

/// A GPS receiver with a fix, ten times a second.
class GpsOnALine final : public simulation::SerialDevice {
 public:
  [[nodiscard]] unsigned baud() const override { return 115200; }
  void advance(Duration now, const Send& send) override {
    for (; next_ <= now; next_ += 100ms) {
      simulation::GpsReading reading;
      reading.time_of_day_ms = 45'000'000 + next_ / 1ms;
      reading.latitude_deg = 47.285233;
      reading.longitude_deg = 8.565265;
      send(next_, as_bytes(print_nmea_burst(reading)));
    }
  }

 private:
  Duration next_ = 100ms;
};

}  // namespace nacelle::test
