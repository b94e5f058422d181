// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "in_machine.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::test {

/// A USB device with a serial line (CDC ACM), plugged into the kernel's own dummy controller: a board whose cable a test can pull.
///
/// The line's end at the robot is /dev/ttyACM0 while it is plugged in, the device's end is what write() and read() use.
/// Source: kernel, Documentation/usb/gadget_configfs.rst.
class AcmGadget {
 public:
  explicit AcmGadget(const Clock& clock) : clock_(clock) {
    namespace fs = std::filesystem;
    fs::create_directory(kFolder);
    write_file(kFolder + "/idVendor", "0x1d6b");
    write_file(kFolder + "/idProduct", "0x0104");
    fs::create_directories(kFolder + "/strings/0x409");
    write_file(kFolder + "/strings/0x409/serialnumber", "0001");
    fs::create_directory(kFolder + "/functions/acm.usb0");
    fs::create_directory(kFolder + "/configs/c.1");
    fs::create_directory_symlink(kFolder + "/functions/acm.usb0", kFolder + "/configs/c.1/acm.usb0");
  }
  AcmGadget(const AcmGadget&) = delete;
  AcmGadget& operator=(const AcmGadget&) = delete;
  ~AcmGadget() {
    namespace fs = std::filesystem;
    unplug();
    fs::remove(kFolder + "/configs/c.1/acm.usb0");
    for (const char* part : {"/configs/c.1", "/functions/acm.usb0", "/strings/0x409", ""}) fs::remove(kFolder + part);
  }

  /// Returns when the robot's end is there.
  void plug() {
    write_file(kFolder + "/UDC", "dummy_udc.0");
    EXPECT_TRUE(wait_for_node(kRobotEnd, clock_));
    end_ = io::Descriptor{::open("/dev/ttyGS0", O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    termios raw{};
    EXPECT_EQ(::tcgetattr(end_.number(), &raw), 0);
    ::cfmakeraw(&raw);
    EXPECT_EQ(::tcsetattr(end_.number(), TCSANOW, &raw), 0);
  }
  void unplug() {
    end_ = {};
    if (!read_word(kFolder + "/UDC").empty()) write_file(kFolder + "/UDC", "\n");
  }

  /// Sends all bytes; false if the line takes none for kPatience.
  [[nodiscard]] bool write(ByteView bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(end_.number(), bytes.data(), bytes.size());
      if (count > 0) bytes = bytes.subspan(static_cast<std::size_t>(count));
      if (count > 0) continue;
      if (io::wait_writable(end_.number(), clock_, clock_.now() + kPatience) != io::Wake::Ready) return false;
    }
    return true;
  }
  /// What the robot sent, up to so many bytes; fewer if none come for kPatience.
  [[nodiscard]] Bytes read(std::size_t count) {
    Bytes all;
    Bell never;
    while (all.size() < count) {
      if (io::wait_readable(end_.number(), never, clock_, clock_.now() + kPatience) != io::Wake::Ready) break;
      std::array<std::uint8_t, 4096> buffer{};
      const ssize_t got = ::read(end_.number(), buffer.data(), buffer.size());
      if (got > 0) all.insert(all.end(), buffer.begin(), buffer.begin() + got);
    }
    return all;
  }

  inline static const std::string kRobotEnd = "/dev/ttyACM0";

 private:
  inline static const std::string kFolder = "/sys/kernel/config/usb_gadget/nacelle";
  const Clock& clock_;
  io::Descriptor end_;
};

}  // namespace nacelle::test
