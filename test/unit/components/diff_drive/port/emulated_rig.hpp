// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "../firmware/simulated_board.hpp"
#include "base_rig.hpp"
#include "diff_drive/component/hiwonder_board.hpp"
#include "diff_drive/component/home_made_board.hpp"
#include "diff_drive/component/odrive_board.hpp"
#include "diff_drive/component/roboclaw_board.hpp"
#include "diff_drive/component/vesc_board.hpp"
#include "simulation/protocol/hiwonder_device.hpp"
#include "simulation/protocol/odrive_device.hpp"
#include "simulation/protocol/roboclaw_device.hpp"
#include "simulation/protocol/vesc_device.hpp"

namespace nacelle::diff_drive {

/// Hears what a port says, faults too.
class AllEars final : public WheelStateSink {
 public:
  void on_wheel_state(const WheelState& state) override { states.push_back(state); }
  void on_board_fault(const char* fault) override { faults.push_back(fault); }
  std::vector<WheelState> states;
  std::vector<const char*> faults;
};

/// A port, a pty, and an emulated board at its other end, all in one thread: time is told, and nothing waits for it.
class EmulatedRig : public BaseRig {
 public:
  EmulatedRig(std::unique_ptr<MotorBoard> board, std::unique_ptr<simulation::MotorDevice> device)
      : device_(std::move(device)) {
    auto line = io::SerialPort::open({pty_->path(), 115200, 100ms}, clock_);
    SerialBasePort::Settings settings;
    settings.max_wheel_rate_rps = 60.0;
    port_ = std::make_unique<SerialBasePort>(std::move(line).value(), std::move(board), clock_, settings);
  }

  BasePort& port() override { return *port_; }
  const Clock& clock() override { return clock_; }
  void advance(Duration by) { clock_.advance(by); }
  simulation::MotorDevice& device() { return *device_; }

  WheelState run(Duration length) override {
    settle();
    turn(length);
    AllEars heard;
    for (int i = 0; i < 100 && heard.states.empty(); ++i) exchange(heard);
    states += heard.states.size();
    if (!heard.faults.empty()) fault = heard.faults.back();
    return heard.states.empty() ? WheelState{} : heard.states.back();
  }
  /// As last reported by the board.
  const char* fault = nullptr;
  void write_as_stranger(ByteView bytes) override {
    static_cast<void>(!::write(port_->descriptor(), bytes.data(), bytes.size()));
    static_cast<void>(let_the_board_read());
  }

  /// All that is on its way arrives, and what it causes.
  void settle() {
    AllEars heard;
    while (exchange(heard)) {}
    states += heard.states.size();
    if (!heard.faults.empty()) fault = heard.faults.back();
  }
  /// The wheels turn as commanded for so long, in steps of 10 ms.
  void turn(Duration length) {
    for (Duration done{}; done < length; done += 10ms) {
      clock_.advance(10ms);
      left_rad_ += 0.01 * device_->left_target_rps();
      right_rad_ += 0.01 * device_->right_target_rps();
      send(device_->step(world_time(), left_rad_, right_rad_));
    }
  }
  [[nodiscard]] Duration world_time() const { return clock_.now().since_origin; }

  /// Garbles the board's next answers: called with each before it is sent.
  std::function<void(Bytes&)> on_answer = [](Bytes&) {};

 private:
  static constexpr std::string_view kMark = "\x1b[the test's own mark]\x1b";

  void send(Bytes bytes) {
    if (bytes.empty()) return;
    on_answer(bytes);
    sent_ += pty_->write_some(bytes);
  }
  /// Returns once the board has read all that the port wrote; true if it answered.
  bool let_the_board_read() {
    static_cast<void>(!::write(port_->descriptor(), kMark.data(), kMark.size()));
    std::string text;
    while (!text.ends_with(kMark)) {
      pollfd watched{pty_->device_end(), POLLIN, 0};
      if (::poll(&watched, 1, 2000) <= 0) return false;
      const auto bytes = pty_->read();
      if (!bytes) return false;
      text += as_text(bytes.value());
    }
    text.resize(text.size() - kMark.size());
    const std::uint64_t before = sent_;
    send(device_->on_bytes(as_bytes(text), world_time()));
    return sent_ != before;
  }
  /// One turn each; false when neither has anything more to say.
  bool exchange(WheelStateSink& heard) {
    if (!port_->read_until({}, heard)) return false;
    const bool answered = let_the_board_read();
    bool arrived = false;
    while (port_->stats().bytes_in < sent_) {
      pollfd watched{port_->descriptor(), POLLIN, 0};
      if (::poll(&watched, 1, 2000) <= 0 || !port_->read_until({}, heard)) return false;
      arrived = true;
    }
    return answered || arrived;
  }

  ToldClock clock_;
  std::unique_ptr<io::PtyPair> pty_ = io::PtyPair::create().value();
  std::unique_ptr<simulation::MotorDevice> device_;
  std::unique_ptr<SerialBasePort> port_;
  double left_rad_ = 0.0, right_rad_ = 0.0;
  std::uint64_t sent_ = 0;
};

class RoboclawRig final : public EmulatedRig {
 public:
  static constexpr double kCounts = 40000.0;
  explicit RoboclawRig(simulation::RoboclawDevice::Settings device = {.counts_per_turn = kCounts},
                       RoboclawBoard::Settings board = {.wiring = {{1, false}, {2, false}, kCounts},
                                                        .motor_watchdog = 2s})
      : EmulatedRig(std::make_unique<RoboclawBoard>(board), std::make_unique<simulation::RoboclawDevice>(device)) {}
  simulation::RoboclawDevice& roboclaw() { return static_cast<simulation::RoboclawDevice&>(device()); }
};

/// A hub motor with so many pole pairs that its tachometer resolves what the laws measure.
class VescRig final : public EmulatedRig {
 public:
  static constexpr int kPolePairs = 4000;
  VescRig()
      : EmulatedRig(std::make_unique<VescBoard>(
                        VescBoard::Settings{{{VescPrinter::kOnTheLine, false}, {42, false}, 6.0 * kPolePairs}}),
                    std::make_unique<simulation::VescDevice>(
                        simulation::VescDevice::Settings{.pole_pairs = kPolePairs, .timeout = 2s})) {}
  simulation::VescDevice& vesc() { return static_cast<simulation::VescDevice&>(device()); }
};

class OdriveRig final : public EmulatedRig {
 public:
  explicit OdriveRig(simulation::OdriveDevice::Settings device = {})
      : EmulatedRig(std::make_unique<OdriveBoard>(OdriveBoard::Settings{.motor_watchdog = 2s}),
                    std::make_unique<simulation::OdriveDevice>(device)) {}
  simulation::OdriveDevice& odrive() { return static_cast<simulation::OdriveDevice&>(device()); }
};

class HiwonderRig final : public EmulatedRig {
 public:
  explicit HiwonderRig(HiwonderBoard::Settings board = {})
      : EmulatedRig(std::make_unique<HiwonderBoard>(board), std::make_unique<simulation::HiwonderDevice>()) {}
  /// The board reports nothing about its wheels, so what another writer commands is seen at the motors only.
  WheelRates rates_after(Duration length) override {
    run(length);
    return {device().left_target_rps(), device().right_target_rps()};
  }
  simulation::HiwonderDevice& hiwonder() { return static_cast<simulation::HiwonderDevice&>(device()); }
};

/// A home-made board with the reference firmware.
template <typename Board>
class HomeMadeRig final : public EmulatedRig {
 public:
  HomeMadeRig()
      : EmulatedRig(std::make_unique<Board>(HomeMadeSettings{{{0, false}, {1, false}, SimulatedBoard::kCounts},
                                                             std::chrono::milliseconds{2000}}),
                    std::make_unique<SimulatedBoard>()) {}
  SimulatedBoard& board() { return static_cast<SimulatedBoard&>(device()); }
};
using FramedRig = HomeMadeRig<FramedBoard>;
using TextRig = HomeMadeRig<TextBoard>;

}  // namespace nacelle::diff_drive
