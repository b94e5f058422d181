// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "in_machine.hpp"

namespace nacelle::test {

/// The I2C bus of the module i2c-regsim (test/vm/modules) with its chip of 256 registers, which it keeps while the bus is unplugged.
class Regsim {
 public:
  static constexpr std::uint8_t kAddress = 0x68;

  /// "/dev/i2c-0": the bus; empty while it is unplugged.
  [[nodiscard]] static std::string path() {
    for (const auto& entry : std::filesystem::directory_iterator{kDevice}) {
      const std::string name = entry.path().filename();
      if (name.starts_with("i2c-")) return "/dev/" + name;
    }
    return {};
  }
  /// The bus goes away, as a USB adapter whose cable is pulled.
  static void unplug() { write_file(kDevice + "/plugged", "0"); }
  /// The bus comes back. A failure of the test if a program has kept the old one open for a minute.
  static void plug() { write_file(kDevice + "/plugged", "1"); }

  /// The chip answers, or is not there.
  static void power(bool on) { set("addr", on ? kAddress : 0); }
  /// Every n-th transfer is not acknowledged; 0: none.
  static void lose_every(unsigned n) { set("nak_every", n); }
  /// A line of the bus is held: transfers time out.
  static void hold(bool on) { set("stuck", on ? 1 : 0); }
  [[nodiscard]] static unsigned transfers() {
    return static_cast<unsigned>(std::stoul(read_word(kParameters + "transfers")));
  }

  static void write(std::size_t first, const std::string& bytes) {
    std::fstream file{kDevice + "/regs", std::ios::in | std::ios::out | std::ios::binary};
    file.seekp(static_cast<std::streamoff>(first));
    file << bytes << std::flush;
    EXPECT_TRUE(file) << "registers from " << first;
  }
  [[nodiscard]] static std::uint8_t read(std::size_t reg) {
    std::ifstream file{kDevice + "/regs", std::ios::binary};
    std::array<char, 256> all{};
    file.read(all.data(), all.size());
    EXPECT_TRUE(file);
    return static_cast<std::uint8_t>(all.at(reg));
  }

 private:
  static void set(const std::string& name, unsigned value) { write_file(kParameters + name, std::to_string(value)); }

  inline static const std::string kDevice = "/sys/devices/platform/i2c-regsim";
  inline static const std::string kParameters = "/sys/module/i2c_regsim/parameters/";
};

}  // namespace nacelle::test
