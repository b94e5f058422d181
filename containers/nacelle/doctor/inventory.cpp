// SPDX-License-Identifier: Apache-2.0
#include "doctor/inventory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

namespace nacelle::doctor {
namespace {

struct UsbGuess {
  std::string_view usb, what;
};
// Source: the vendor numbers of usb.ids; what the makers of robot parts build with them.
constexpr std::array kGuesses{
    UsbGuess{"10c4:ea60", "an adapter: RPLIDAR, YDLIDAR, LD06 kit or another serial device"},
    UsbGuess{"1a86:7523", "an adapter (CH340): Arduino Nano, WT901, motor board"},
    UsbGuess{"1a86:55d3", "an adapter (CH343): Waveshare board"},
    UsbGuess{"1a86:55d4", "an adapter (CH9102): ESP32 or Hiwonder board"},
    UsbGuess{"0403:6001", "an adapter (FTDI)"},
    UsbGuess{"0403:6015", "an adapter (FTDI)"},
    UsbGuess{"067b:2303", "an adapter (PL2303): GPS receiver"},
    UsbGuess{"03eb:2404", "RoboClaw"},
    UsbGuess{"1209:0d32", "ODrive"},
    UsbGuess{"0483:5740", "an STM32: VESC or a home-made board"},
    UsbGuess{"1546:01a8", "u-blox GPS receiver"},
    UsbGuess{"1546:01a7", "u-blox GPS receiver"},
};

std::string guess_of(const std::string& usb) {
  const auto* const found =
      std::find_if(kGuesses.begin(), kGuesses.end(), [&](const UsbGuess& g) { return g.usb == usb; });
  if (found != kGuesses.end()) return std::string{found->what};
  if (usb.rfind("2341:", 0) == 0) return "Arduino";
  if (usb.rfind("2e8a:", 0) == 0) return "Raspberry Pi Pico";
  if (usb.rfind("16c0:", 0) == 0) return "Teensy or a home-made board";
  return "";
}

/// The folder in /sys of the USB device that `node`'s device belongs to, or an empty text.
std::string usb_folder(const Machine& machine, const std::string& device) {
  std::string folder = machine.resolved(device);
  for (int i = 0; i < 8 && folder.size() > 1; ++i) {
    if (machine.exists(folder + "/idVendor")) return folder;
    folder = std::filesystem::path{folder}.parent_path().string();
  }
  return "";
}

void add_usb(const Machine& machine, const std::string& device, PluggedIn& found) {
  const std::string folder = usb_folder(machine, device);
  if (folder.empty()) return;
  found.usb =
      machine.text(folder + "/idVendor").value_or("?") + ":" + machine.text(folder + "/idProduct").value_or("?");
  found.serial = machine.text(folder + "/serial").value_or("");
  if (found.name.empty()) found.name = machine.text(folder + "/product").value_or("");
  found.guess = guess_of(found.usb);
}

/// The link in `folder` that leads to `node`, or `node` itself.
std::string lasting_path(const Machine& machine, const std::vector<std::string>& folders, const std::string& node) {
  for (const auto& folder : folders) {
    for (const auto& name : machine.names_in(folder)) {
      const std::string link = std::string{folder}.append("/").append(name);
      if (machine.resolved(link) == node) return link;
    }
  }
  return node;
}

bool begins(const std::string& name, std::string_view beginning) { return name.rfind(beginning, 0) == 0; }

void add_serial(const Machine& machine, std::vector<PluggedIn>& all) {
  for (const auto& name : machine.names_in("/dev")) {
    // Serial lines of a PC's board (ttyS) are there with or without a chip, and mean nothing.
    if (!begins(name, "ttyUSB") && !begins(name, "ttyACM") && !begins(name, "ttyAMA")) continue;
    PluggedIn found{.kind = "serial", .node = "/dev/" + name};
    found.path = lasting_path(machine, {"/dev/serial/by-id", "/dev/serial/by-path"}, found.node);
    add_usb(machine, "/sys/class/tty/" + name + "/device", found);
    if (found.name.empty() && begins(name, "ttyAMA")) found.name = "UART of the board";
    all.push_back(std::move(found));
  }
}

void add_cameras(const Machine& machine, std::vector<PluggedIn>& all) {
  for (const auto& name : machine.names_in("/sys/class/video4linux")) {
    const std::string folder = "/sys/class/video4linux/" + name;
    // The second node of a USB camera carries its metadata.
    if (!begins(name, "video") || machine.number(folder + "/index").value_or(0) != 0) continue;
    PluggedIn found{.kind = "camera", .node = "/dev/" + name, .name = machine.text(folder + "/name").value_or("")};
    found.path = lasting_path(machine, {"/dev/v4l/by-id", "/dev/v4l/by-path"}, found.node);
    add_usb(machine, folder + "/device", found);
    all.push_back(std::move(found));
  }
}

void add_gamepads(const Machine& machine, std::vector<PluggedIn>& all) {
  for (const auto& name : machine.names_in("/dev/input")) {
    if (!begins(name, "js")) continue;
    const std::string device = "/sys/class/input/" + name + "/device";
    PluggedIn found{
        .kind = "gamepad", .node = "/dev/input/" + name, .name = machine.text(device + "/name").value_or("")};
    found.path = lasting_path(machine, {"/dev/input/by-id", "/dev/input/by-path"}, found.node);
    add_usb(machine, device, found);
    all.push_back(std::move(found));
  }
}

void add_buses(const Machine& machine, std::vector<PluggedIn>& all) {
  for (const auto& name : machine.names_in("/dev")) {
    if (!begins(name, "i2c-")) continue;
    const std::string node = "/dev/" + name;
    all.push_back({.kind = "I2C",
                   .path = node,
                   .node = node,
                   .name = machine.text("/sys/class/i2c-dev/" + name + "/name").value_or("")});
  }
  constexpr std::int64_t kCan = 280;  // ARPHRD_CAN, linux/if_arp.h
  for (const auto& name : machine.names_in("/sys/class/net")) {
    const std::string folder = "/sys/class/net/" + name;
    if (machine.number(folder + "/type") != kCan) continue;
    PluggedIn found{.kind = "CAN", .path = name, .node = name};
    found.name = "interface is " + machine.text(folder + "/operstate").value_or("unknown");
    add_usb(machine, folder + "/device", found);
    all.push_back(std::move(found));
  }
}

/// As YAML. Names of devices are text that their makers chose.
std::string as_value(const std::string& device) {
  if (begins(device, "/dev/") && device.find_first_of(" ,[]{}#:'\"") == std::string::npos) return device;
  std::string quoted = "'";
  for (const char c : device) quoted.append(c == '\'' ? 2 : 1, c);
  return quoted + "'";
}

}  // namespace

std::vector<PluggedIn> plugged_in(const Machine& machine) {
  std::vector<PluggedIn> all;
  add_serial(machine, all);
  add_cameras(machine, all);
  add_gamepads(machine, all);
  add_buses(machine, all);
  for (auto& device : all) device.held_by = machine.holders(device.node);
  return all;
}

std::string launch_line(const Driver& driver, const std::string& device) {
  // nacelle::lidar::LidarComponent is a class of the package nacelle_lidar.
  const std::size_t begin = driver.plugin.find("::"), end = driver.plugin.rfind("::");
  const std::string name = driver.plugin.substr(begin + 2, end - begin - 2);
  return fmt::format("- {{pkg: nacelle_{0}, plugin: \"{1}\", name: {0}, param: [{{name: {2}, value: {3}}}{4}{5}]}}",
                     name, driver.plugin, driver.parameter, as_value(device), driver.setting.empty() ? "" : ", ",
                     driver.setting);
}

}  // namespace nacelle::doctor
