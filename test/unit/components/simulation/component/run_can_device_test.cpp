// SPDX-License-Identifier: Apache-2.0
// On a pair of sockets whose messages are frames, as a CAN socket's are. An interface of the kernel is in test/vm.
#include "simulation/component/run_can_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <thread>

#include "simulation/protocol/can_wire.hpp"

namespace nacelle::simulation {
namespace {

using ::testing::HasSubstr;

constexpr Duration kLongestWait = 20s;  // ends a broken build only

class CanDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends), 0);
    bus_ = io::Descriptor{ends[0]};
    port_ = io::CanPort::adopt(io::Descriptor{ends[1]}, {"test-can", {}, 1ms}, clock_);
    device_ = make_can_device("odrive_can");
    ASSERT_TRUE(device_);
    thread_ =
        std::thread{[this] { serve_can_device(*device_, *port_, clock_, [this](Duration) { return ends_.load(); }); }};
  }
  void TearDown() override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  void send(std::uint32_t id, const Bytes& data) {
    Bytes bytes;
    append(bytes, {.id = id, .data = data});
    ASSERT_EQ(::send(bus_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
  }
  /// Reads frames until one fits; false if none does for too long.
  bool wait_for(const std::function<bool(const CanMessage&)>& fits) {
    CanWire wire;
    Bell never;
    const MonotonicTime limit = clock_.now() + kLongestWait;
    while (io::wait_readable(bus_.number(), never, clock_, limit) == io::Wake::Ready) {
      Bytes bytes(io::kCanFrameBytes);
      const ssize_t count = ::recv(bus_.number(), bytes.data(), bytes.size(), 0);
      if (count <= 0) return false;
      for (const CanMessage& message : wire.cut(bytes)) {
        if (fits(message)) return true;
      }
    }
    return false;
  }

  SystemClock clock_;
  io::Descriptor bus_;
  std::unique_ptr<io::CanPort> port_;
  std::unique_ptr<MotorDevice> device_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

Bytes bytes_of(float value) {
  Bytes bytes(sizeof value);
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

TEST_F(CanDevice, says_its_heartbeats_and_turns_its_wheels_as_commanded) {
  EXPECT_TRUE(wait_for([](const CanMessage& m) { return m.id == 0x001; })) << "node 0";
  EXPECT_TRUE(wait_for([](const CanMessage& m) { return m.id == 0x021; })) << "node 1";
  send(0x007, {8, 0, 0, 0});              // node 0: closed loop control
  send(0x00B, {2, 0, 0, 0, 1, 0, 0, 0});  // velocity control, input passed through
  Bytes velocity = bytes_of(1.5F);
  velocity.resize(8);
  send(0x00D, velocity);
  EXPECT_TRUE(wait_for([](const CanMessage& m) {
    if (m.id != 0x009 || m.data.size() != 8) return false;
    float turns_per_s = 0.0F;
    std::memcpy(&turns_per_s, m.data.data() + 4, sizeof turns_per_s);
    return std::abs(turns_per_s - 1.5F) < 0.2F;
  })) << "its encoder says so";
}

TEST(RunCanDevice, names_the_devices_and_how_an_interface_is_made) {
  const SystemClock clock{};
  const auto unknown = run_can_device({"odrive_cam", "nocan9"}, clock, [] {});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().way_out, HasSubstr("odrive_can"));
  const auto absent = run_can_device({"odrive_can", "nocan9"}, clock, [] {});
  ASSERT_FALSE(absent);
  EXPECT_THAT(absent.error().way_out, HasSubstr("sudo ip link add nocan9 type vcan"));
}

}  // namespace
}  // namespace nacelle::simulation
