// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "nacelle/base/bytes.hpp"
#include "nacelle/io/descriptor.hpp"
#include "simulation/protocol/motor_device.hpp"

namespace nacelle::test {

/// A CAN interface of the kernel's vcan driver (loaded with echo=1, so that a frame passes the interface's queue before any program
/// reads it).
class VirtualCan {
 public:
  static constexpr const char* kName = "testcan";

  VirtualCan() { add(); }
  ~VirtualCan() { remove(); }
  VirtualCan(const VirtualCan&) = delete;
  VirtualCan& operator=(const VirtualCan&) = delete;

  void add() {
    run(std::string{"ip link add dev "} + kName + " type vcan");
    set_up(true);
  }
  void remove() { run(std::string{"ip link delete "} + kName + " 2>/dev/null; true"); }
  void set_up(bool up) {
    const io::Descriptor any{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
    ifreq request{};
    std::strncpy(request.ifr_name, kName, sizeof request.ifr_name - 1);
    ASSERT_EQ(::ioctl(any.number(), SIOCGIFFLAGS, &request), 0);
    const unsigned flags = static_cast<unsigned short>(request.ifr_flags);
    request.ifr_flags = static_cast<short>(up ? flags | IFF_UP : flags & ~static_cast<unsigned>(IFF_UP));
    ASSERT_EQ(::ioctl(any.number(), SIOCSIFFLAGS, &request), 0);
  }
  /// Of all frames, in every direction.
  void lose_percent(int percent) {
    run(std::string{"tc qdisc add dev "} + kName + " root netem loss " + std::to_string(percent) + "%");
  }
  [[nodiscard]] int lost_frames() {
    std::FILE* const told = ::popen((std::string{"tc -s qdisc show dev "} + kName).c_str(), "r");
    std::array<char, 4096> text{};
    const std::size_t size = std::fread(text.data(), 1, text.size() - 1, told);
    ::pclose(told);
    const std::string all(text.data(), size);
    const auto at = all.find("dropped ");
    return at == std::string::npos ? -1 : std::atoi(all.c_str() + at + 8);
  }

 private:
  static void run(const std::string& command) { EXPECT_EQ(std::system(command.c_str()), 0) << command; }
};

/// Another program on the bus.
class BusPeer {
 public:
  BusPeer() : socket_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(VirtualCan::kName));
    EXPECT_EQ(::bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  bool send(const Bytes& frame) const {
    // The kernel reports to the first attempt that the interface was down, though it is up again.
    return try_to_send(frame) || (errno == ENETDOWN && try_to_send(frame));
  }
  bool send(std::uint32_t id, const Bytes& data = {}) const { return send(frame(id, data)); }
  /// The next frame, waited for until the deadline; empty if none came.
  [[nodiscard]] Bytes receive(const Clock& clock, MonotonicTime deadline) {
    if (io::wait_readable(socket_.number(), never_, clock, deadline) != io::Wake::Ready) return {};
    return receive();
  }
  [[nodiscard]] Bytes receive() const {
    Bytes bytes(sizeof(can_frame));
    return ::recv(socket_.number(), bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()) ? bytes
                                                                                                         : Bytes{};
  }

  [[nodiscard]] static Bytes frame(std::uint32_t id, const Bytes& data = {}) {
    can_frame raw{};
    raw.can_id = id;
    raw.can_dlc = static_cast<__u8>(data.size());
    std::copy(data.begin(), data.end(), raw.data);
    Bytes bytes(sizeof raw);
    std::memcpy(bytes.data(), &raw, sizeof raw);
    return bytes;
  }
  /// What a controller reports when it goes off the bus.
  [[nodiscard]] static Bytes bus_off() { return frame(CAN_ERR_FLAG | CAN_ERR_BUSOFF, Bytes(8)); }

 private:
  [[nodiscard]] bool try_to_send(const Bytes& frame) const {
    return ::send(socket_.number(), frame.data(), frame.size(), 0) == static_cast<ssize_t>(frame.size());
  }

  io::Descriptor socket_;
  Bell never_;
};

/// Emulated boards whose wheels turn as commanded, on the bus, in a thread of their own.
class BoardsOnBus {
 public:
  explicit BoardsOnBus(std::unique_ptr<simulation::MotorDevice> device)
      : device_(std::move(device)), thread_{[this] { run(); }} {}
  ~BoardsOnBus() {
    stop_ = true;
    thread_.join();
  }
  BoardsOnBus(const BoardsOnBus&) = delete;
  BoardsOnBus& operator=(const BoardsOnBus&) = delete;

  /// rad/s, as last commanded.
  [[nodiscard]] double left_target_rps() const { return left_; }
  [[nodiscard]] double right_target_rps() const { return right_; }

 private:
  void run() {
    const MonotonicTime begin = clock_.now();
    MonotonicTime before = begin;
    double left_rad = 0.0, right_rad = 0.0;
    while (!stop_) {
      const Bytes heard = peer_.receive(clock_, clock_.now() + 2ms);
      const MonotonicTime now = clock_.now();
      if (!heard.empty()) say(device_->on_bytes(heard, now - begin));
      left_ = device_->left_target_rps();
      right_ = device_->right_target_rps();
      left_rad += left_ * to_seconds(now - before);
      right_rad += right_ * to_seconds(now - before);
      before = now;
      say(device_->step(now - begin, left_rad, right_rad));
    }
  }
  // A bus that is down takes nothing, as a cable that is out.
  void say(const Bytes& frames) const {
    for (std::size_t at = 0; at + sizeof(can_frame) <= frames.size(); at += sizeof(can_frame)) {
      const auto frame = frames.begin() + static_cast<std::ptrdiff_t>(at);
      static_cast<void>(peer_.send({frame, frame + sizeof(can_frame)}));
    }
  }

  SystemClock clock_;
  BusPeer peer_;
  const std::unique_ptr<simulation::MotorDevice> device_;
  std::atomic<double> left_{0.0}, right_{0.0};
  std::atomic<bool> stop_{false};
  std::thread thread_;  // last: it uses the others
};

}  // namespace nacelle::test
