// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/version.hpp"
#include "doctor/inventory.hpp"
#include "doctor/listen.hpp"
#include "nacelle/base/problem_json.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using doctor::PluggedIn;
using nlohmann::json;

constexpr Duration kListening = 600ms;  // two frames of the slowest device that is known, which sends ten a second

struct DeviceWish {
  bool listen = false, as_json = false;
};

/// A device, and what listening to it has found.
struct Found {
  PluggedIn device;
  std::optional<Result<doctor::HeardDevice, Problem>> heard{};

  [[nodiscard]] const io::SerialDevice* recognised() const {
    return heard && heard->has_value() ? heard->value().device : nullptr;
  }
  [[nodiscard]] std::optional<doctor::Driver> driver() const {
    if (device.kind == "camera") return doctor::Driver{"nacelle::camera::CameraComponent", "video_device", ""};
    if (device.kind == "gamepad") return doctor::Driver{"nacelle::joy::JoyComponent", "device_name", ""};
    const io::SerialDevice* const known = recognised();
    if (known == nullptr || known->plugin.empty()) return std::nullopt;
    return doctor::Driver{std::string{known->plugin}, std::string{known->port}, std::string{known->setting}};
  }
  /// What the driver's parameter is set to. The driver finds a gamepad by its name: the path is that of another interface.
  [[nodiscard]] const std::string& value() const { return device.kind == "gamepad" ? device.name : device.path; }
  [[nodiscard]] std::string what_was_heard() const {
    if (!heard) return "";
    if (!heard->has_value()) return heard->error().text();
    const doctor::HeardDevice& line = heard->value();
    if (line.device != nullptr) return fmt::format("sends frames of a {} at {} baud", line.device->name, line.baud);
    return line.bytes == 0 ? "is silent: it may wait for a command"
                           : fmt::format("sends {} bytes of no known device", line.bytes);
  }
};

std::vector<Found> look(const DeviceWish& wish) {
  const SystemClock clock;
  std::vector<Found> all;
  for (auto& device : doctor::plugged_in(doctor::Machine{doctor::real_facts(program_version())})) {
    Found found{std::move(device)};
    if (wish.listen && found.device.kind == "serial" && found.device.held_by.empty()) {
      if (!wish.as_json) std::fprintf(stderr, "listening to %s\n", found.device.path.c_str());
      found.heard = doctor::listen(found.device.node, clock, kListening);
    }
    all.push_back(std::move(found));
  }
  return all;
}

void print(const Found& found) {
  const PluggedIn& device = found.device;
  print_text("%-8s%s%s\n", device.kind.c_str(), device.path.c_str(),
             device.path == device.node ? "" : fmt::format(" -> {}", device.node).c_str());
  std::string about = device.name;
  if (!device.usb.empty()) about += fmt::format("{}USB {}", about.empty() ? "" : ", ", device.usb);
  if (!device.serial.empty()) about += ", serial number " + device.serial;
  if (!about.empty()) print_text("        %s\n", about.c_str());
  if (!device.held_by.empty()) print_text("        in use by %s\n", doctor::names_of(device.held_by).c_str());
  if (const std::string heard = found.what_was_heard(); !heard.empty()) print_text("        %s\n", heard.c_str());
  if (found.recognised() == nullptr && !device.guess.empty()) print_text("        probably %s\n", device.guess.c_str());
  if (const auto driver = found.driver())
    print_text("        %s\n", doctor::launch_line(*driver, found.value()).c_str());
}

json row_of(const Found& found) {
  const PluggedIn& device = found.device;
  json row{{"kind", device.kind}, {"path", device.path},     {"node", device.node},   {"name", device.name},
           {"usb", device.usb},   {"serial", device.serial}, {"guess", device.guess}, {"held_by", json::array()}};
  for (const auto& process : device.held_by) row["held_by"].push_back({{"pid", process.pid}, {"name", process.name}});
  if (found.heard && !found.heard->has_value()) row["problem"] = found.heard->error();
  if (const io::SerialDevice* const known = found.recognised(); known != nullptr) {
    row["recognised"] = known->name;
    row["baud"] = found.heard->value().baud;
  }
  if (const auto driver = found.driver()) row["launch"] = doctor::launch_line(*driver, found.value());
  return row;
}

int list(const DeviceWish& wish) {
  const auto all = look(wish);
  if (wish.as_json) {
    json rows = json::array();
    for (const auto& found : all) rows.push_back(row_of(found));
    std::printf("%s\n", json{{"devices", std::move(rows)}}.dump(2).c_str());
    return kDone;
  }
  for (const auto& found : all) print(found);
  if (all.empty())
    print_text(
        "no serial line, camera, gamepad, I2C bus or CAN interface is there; `dmesg | tail` names what was plugged "
        "in\n");
  return kDone;
}

}  // namespace

void add_device_commands(Command& root) {
  auto wish = std::make_shared<DeviceWish>();
  Command& device = root.add("device", "list the devices that are plugged in");
  Command& command =
      device.add("list", "list the devices that are plugged in, and the lines of a launch file that use them");
  command.flag(
      "--listen", wish->listen,
      "listen to the serial lines that nobody uses, to recognise their devices; opening a line restarts some boards");
  command.flag("--json", wish->as_json, "print one JSON object: devices");
  command.note("Writes to no device. Without --listen it opens none.");
  command.runs([wish] { return list(*wish); });
}

}  // namespace nacelle::cli
