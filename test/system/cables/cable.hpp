// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "nacelle/io/descriptor.hpp"
#include "nacelle/io/pty_pair.hpp"
#include "simulation/model/paced_line.hpp"
#include "simulation/model/serial_device.hpp"

namespace nacelle::test {

/// An emulated device in real time behind a path as udev makes one, with a cable and a power supply that a test pulls.
///
/// Threads: one, but the device runs in one of its own while it has power.
class Cable {
 public:
  using MakeDevice = std::function<std::unique_ptr<simulation::SerialDevice>()>;
  Cable(std::string path, MakeDevice make) : path_(std::move(path)), make_(std::move(make)) { plug(); }
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;
  ~Cable() { unplug(); }

  /// The path is there again, and the device has power anew: it has forgotten all settings and commands.
  void plug() {
    auto pty = io::PtyPair::create();
    ASSERT_TRUE(pty) << pty.error().text();
    pty_ = std::move(pty).value();
    const auto linked = pty_->link_as(path_);
    ASSERT_TRUE(linked) << linked.error().text();
    power_on();
  }
  /// The path is gone, and the line hangs up.
  void unplug() {
    power_off();
    pty_.reset();
  }
  /// As plug() and unplug(), of a device that does not get its power from its cable: the line stays open.
  void power_on() {
    stops_ = false;
    thread_ = std::thread{[this] { run(); }};
  }
  void power_off() {
    if (!thread_.joinable()) return;
    stops_ = true;
    bell_.ring();
    thread_.join();
  }

 private:
  // A device that was kept from running for longer jumps.
  static constexpr Duration kMostCatchUp = 200ms;

  void run() {
    const auto device = make_();
    simulation::PacedLine paced{device->baud()};
    MonotonicTime origin = clock_.now();
    Duration last{};
    while (!stops_) {
      static_cast<void>(io::wait_readable(pty_->device_end(), bell_, clock_, clock_.now() + 1ms));
      if (clock_.now() - origin - last > kMostCatchUp) origin = clock_.now() - last;
      const Duration now = last = clock_.now() - origin;
      if (const auto bytes = pty_->read(); bytes && !bytes->empty()) device->receive(*bytes, now);
      device->advance(now, [&](Duration at, ByteView bytes) { paced.send(at, bytes); });
      paced.release(now, [&](ByteView bytes) { static_cast<void>(pty_->write_some(bytes)); });
    }
  }

  const std::string path_;
  const MakeDevice make_;
  SystemClock clock_;
  std::unique_ptr<io::PtyPair> pty_;
  Bell bell_;
  std::atomic<bool> stops_{false};
  std::thread thread_;
};

}  // namespace nacelle::test
