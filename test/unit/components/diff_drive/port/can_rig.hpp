// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "base_rig.hpp"
#include "diff_drive/component/odrive_can_board.hpp"
#include "diff_drive/component/vesc_can_board.hpp"
#include "emulated_rig.hpp"
#include "simulation/protocol/odrive_can_device.hpp"
#include "simulation/protocol/vesc_can_device.hpp"

namespace nacelle::diff_drive {

/// A CAN bus in memory, with emulated boards on it: as io::CanPort, its bytes are whole frames. The test sets the time.
class BusInMemory final : public io::ByteStream {
 public:
  static constexpr std::size_t kFrame = 16;
  BusInMemory(simulation::MotorDevice& device, const Clock& clock) : device_(device), clock_(clock) {}

  [[nodiscard]] Result<ByteView, io::StreamFault> read_until(MonotonicTime) override {
    if (fault) return err(*std::exchange(fault, std::nullopt));
    chunk_ = std::exchange(waiting_, {});
    return ByteView{chunk_};
  }
  [[nodiscard]] Result<void, io::StreamFault> write(ByteView bytes) override {
    EXPECT_EQ(bytes.size() % kFrame, 0U) << "a CAN socket takes whole frames";
    for (; bytes.size() >= kFrame; bytes = bytes.subspan(kFrame)) {
      const Bytes frame(bytes.begin(), bytes.begin() + kFrame);
      if (write_fault) return err(*write_fault);
      written.push_back(frame);
      if (!loses(frame)) on_its_way_.insert(on_its_way_.end(), frame.begin(), frame.end());
    }
    return {};
  }
  /// What was written reaches the boards, and their answers come.
  void deliver() { say(device_.on_bytes(std::exchange(on_its_way_, {}), clock_.now().since_origin)); }
  void interrupt() noexcept override {}
  [[nodiscard]] Result<void, io::StreamFault> reopen() override {
    if (fault_of_reopen) return err(*fault_of_reopen);
    return {};
  }
  /// Of a stop frame's registration only.
  [[nodiscard]] int descriptor() const noexcept override { return number_.number(); }

  /// What devices say, frame by frame.
  void say(ByteView bytes) {
    for (; bytes.size() >= kFrame; bytes = bytes.subspan(kFrame)) {
      const Bytes frame(bytes.begin(), bytes.begin() + kFrame);
      if (!loses(frame)) waiting_.insert(waiting_.end(), frame.begin(), frame.end());
    }
  }

  std::function<bool(const Bytes& frame)> loses = [](const Bytes&) { return false; };
  std::optional<io::StreamFault> fault, write_fault, fault_of_reopen;
  std::vector<Bytes> written;

 private:
  simulation::MotorDevice& device_;
  const Clock& clock_;
  const io::Descriptor number_{::open("/dev/null", O_RDWR | O_CLOEXEC)};
  Bytes on_its_way_, waiting_, chunk_;
};

/// The identifier of a frame of 16 bytes, flags included.
inline std::uint32_t id_of(const Bytes& frame) {
  return frame[0] | (frame[1] << 8) | (frame[2] << 16) | (static_cast<std::uint32_t>(frame[3]) << 24);
}

/// A port, a bus in memory and emulated boards. The port reads at every step of 1 ms.
class CanRig : public BaseRig {
 public:
  CanRig(std::unique_ptr<MotorBoard> board, std::unique_ptr<simulation::MotorDevice> device)
      : device_(std::move(device)) {
    auto bus = std::make_unique<BusInMemory>(*device_, clock_);
    bus_ = bus.get();
    SerialBasePort::Settings settings;
    settings.max_wheel_rate_rps = 60.0;
    port_ = std::make_unique<SerialBasePort>(std::move(bus), std::move(board), clock_, settings);
  }

  BasePort& port() override { return *port_; }
  const Clock& clock() override { return clock_; }
  simulation::MotorDevice& device() { return *device_; }
  BusInMemory& bus() { return *bus_; }

  WheelState run(Duration length) override {
    heard.states.clear();
    turn(length);  // the suite's lengths are multiples of the boards' periods: the last state is of its end
    states += heard.states.size();
    return heard.states.empty() ? WheelState{} : heard.states.back();
  }
  void turn(Duration length) {
    for (Duration done{}; done < length; done += 1ms) {
      clock_.advance(1ms);
      bus_->deliver();
      left_rad_ += 0.001 * device_->left_target_rps();
      right_rad_ += 0.001 * device_->right_target_rps();
      bus_->say(device_->step(clock_.now().since_origin, left_rad_, right_rad_));
      hear();
    }
  }
  void hear() {
    AllEars ears;
    const auto read = port_->read_until({}, ears);
    if (!read) fault_of_bus = read.error();
    heard.states.insert(heard.states.end(), ears.states.begin(), ears.states.end());
    if (!ears.faults.empty()) fault = ears.faults.back();
  }
  void write_as_stranger(ByteView bytes) override {
    ASSERT_TRUE(bus_->write(bytes));
    bus_->deliver();
  }
  bool can_tear() const override { return false; }

  AllEars heard;
  const char* fault = nullptr;
  std::optional<BaseFault> fault_of_bus;

 private:
  ToldClock clock_;
  std::unique_ptr<simulation::MotorDevice> device_;
  std::unique_ptr<SerialBasePort> port_;
  BusInMemory* bus_ = nullptr;
  double left_rad_ = 0.0, right_rad_ = 0.0;
};

class OdriveCanRig final : public CanRig {
 public:
  explicit OdriveCanRig(const simulation::OdriveCanDevice::Settings& device = {},
                        const OdriveCanBoard::Settings& board = {})
      : CanRig(std::make_unique<OdriveCanBoard>(board), std::make_unique<simulation::OdriveCanDevice>(device)) {}
  simulation::OdriveCanDevice& odrive() { return static_cast<simulation::OdriveCanDevice&>(device()); }
};

/// Hub motors with so many pole pairs that their tachometers resolve what the laws measure.
class VescCanRig final : public CanRig {
 public:
  static constexpr int kPolePairs = 4000;
  explicit VescCanRig(simulation::VescCanDevice::Settings device = {.pole_pairs = kPolePairs, .timeout = 2s})
      : CanRig(std::make_unique<VescCanBoard>(VescCanBoard::Settings{{{7, false}, {42, false}, 6.0 * kPolePairs}}),
               std::make_unique<simulation::VescCanDevice>(device)) {}
  simulation::VescCanDevice& vesc() { return static_cast<simulation::VescCanDevice&>(device()); }
};

}  // namespace nacelle::diff_drive
