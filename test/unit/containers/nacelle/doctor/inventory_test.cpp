// SPDX-License-Identifier: Apache-2.0
#include "doctor/inventory.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "doctor/listen.hpp"
#include "machine_of_files.hpp"
#include "nacelle/io/line_signature.hpp"
#include "nacelle/io/pty_pair.hpp"
#include "nacelle/launch/load_plan.hpp"

namespace nacelle::doctor {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

struct Inventory : MachineOfFiles {
  /// A device of the kernel's class that belongs to a USB device, as /sys shows it.
  void usb(const std::string& class_name, const std::string& name, const std::string& vendor,
           const std::string& product_number, const std::string& product) const {
    const std::string device = "/sys/devices/usb1/1-1";
    write(device + "/idVendor", vendor + "\n");
    write(device + "/idProduct", product_number + "\n");
    write(device + "/product", product + "\n");
    write(device + "/serial", "0001\n");
    write(device + "/1-1:1.0/" + name + "/port_number", "0\n");
    std::filesystem::create_directories(at("/sys/class/" + class_name + "/" + name));
    std::filesystem::create_symlink("../../../devices/usb1/1-1/1-1:1.0/" + name,
                                    at("/sys/class/" + class_name + "/" + name + "/device"));
  }
};

TEST_F(Inventory, a_machine_with_nothing_plugged_in_has_none) {
  plug_in("/dev/ttyS0");
  EXPECT_THAT(plugged_in(machine()), IsEmpty());
}

TEST_F(Inventory, a_serial_adapter_is_known_by_its_lasting_name_and_its_usb_numbers) {
  plug_in("/dev/ttyUSB0");
  usb("tty", "ttyUSB0", "10c4", "ea60", "CP2102 USB to UART Bridge Controller");
  std::filesystem::create_directories(at("/dev/serial/by-id"));
  std::filesystem::create_symlink("../../ttyUSB0", at("/dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00-port0"));
  run(812, "cat", "/dev/ttyUSB0");

  const auto all = plugged_in(machine());

  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].kind, "serial");
  EXPECT_EQ(all[0].path, "/dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00-port0");
  EXPECT_EQ(all[0].node, "/dev/ttyUSB0");
  EXPECT_EQ(all[0].name, "CP2102 USB to UART Bridge Controller");
  EXPECT_EQ(all[0].usb, "10c4:ea60");
  EXPECT_EQ(all[0].serial, "0001");
  EXPECT_THAT(all[0].guess, HasSubstr("RPLIDAR"));
  EXPECT_EQ(all[0].held_by, std::vector<Process>({{812, "cat"}}));
}

TEST_F(Inventory, a_camera_has_one_entry_and_its_metadata_node_none) {
  write("/sys/class/video4linux/video0/name", "USB camera\n");
  write("/sys/class/video4linux/video0/index", "0\n");
  write("/sys/class/video4linux/video1/name", "USB camera\n");
  write("/sys/class/video4linux/video1/index", "1\n");

  const auto all = plugged_in(machine());

  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].kind, "camera");
  EXPECT_EQ(all[0].path, "/dev/video0");
  EXPECT_EQ(all[0].name, "USB camera");
}

TEST_F(Inventory, buses_and_gamepads_are_listed) {
  plug_in("/dev/i2c-1");
  write("/sys/class/i2c-dev/i2c-1/name", "bcm2835 (i2c@7e804000)\n");
  write("/sys/class/net/can0/type", "280\n");
  write("/sys/class/net/can0/operstate", "down\n");
  write("/sys/class/net/eth0/type", "1\n");
  plug_in("/dev/input/js0");
  write("/sys/class/input/js0/device/name", "Xbox Wireless Controller\n");

  const auto all = plugged_in(machine());

  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0].kind + " " + all[0].name, "gamepad Xbox Wireless Controller");
  EXPECT_EQ(all[1].kind + " " + all[1].path, "I2C /dev/i2c-1");
  EXPECT_EQ(all[2].kind + " " + all[2].path + ": " + all[2].name, "CAN can0: interface is down");
}

TEST(LaunchLine, loads_the_driver_for_the_device) {
  EXPECT_EQ(launch_line({"nacelle::lidar::LidarComponent", "port_name", ""}, "/dev/ttyUSB0"),
            "- {pkg: nacelle_lidar, plugin: \"nacelle::lidar::LidarComponent\", name: lidar, param: [{name: port_name, "
            "value: /dev/ttyUSB0}]}");
}

/// What a launch file with this line loads.
launch::ComponentPlan component_of(const std::string& line) {
  const std::string text =
      "launch:\n- node_container:\n    pkg: rclcpp_components\n    exec: component_container\n    name: robot\n"
      "    namespace: ''\n    composable_node:\n    " +
      line + "\n";
  const auto plan = launch::load_plan_text(text, "a.launch.yaml", {}, launch::system_environment());
  if (plan && plan->components.size() == 1) return plan->components[0];
  ADD_FAILURE() << text << (plan ? "" : plan.error()[0].text());
  return {};
}
std::string text_of(const launch::ComponentPlan& component, const std::string& name) {
  for (const auto& parameter : component.parameters) {
    if (parameter.name != name) continue;
    const auto* const text = std::get_if<std::string>(&parameter.value);
    return text != nullptr ? *text : "not a text";
  }
  return "none";
}

TEST(LaunchLine, is_one_of_a_launch_file_for_every_device_that_is_recognised) {
  for (const auto& device : io::known_serial_devices()) {
    if (device.plugin.empty()) continue;
    const Driver driver{std::string{device.plugin}, std::string{device.port}, std::string{device.setting}};
    const auto component = component_of(launch_line(driver, "/dev/serial/by-id/usb-1a86_USB-if00"));
    EXPECT_EQ(component.plugin, device.plugin);
    EXPECT_EQ(text_of(component, driver.parameter), "/dev/serial/by-id/usb-1a86_USB-if00");
    EXPECT_EQ(component.parameters.size(), device.setting.empty() ? 1U : 2U) << device.name;
  }
}

TEST(LaunchLine, keeps_what_a_maker_called_a_gamepad) {
  const std::string name = "Nobody's: Pad #2, {wireless}";
  const auto component = component_of(launch_line({"nacelle::joy::JoyComponent", "device_name", ""}, name));
  EXPECT_EQ(text_of(component, "device_name"), name);
}

// A real kernel terminal. The listener ends with the first two frames; the time is for a broken build.
TEST(Listening, recognises_a_device_and_writes_nothing) {
  const SystemClock clock;
  auto pty = io::PtyPair::create();
  ASSERT_TRUE(pty);
  const std::string line = "$GPRMC,081836,A,3751.65,S,14507.36,E,000.0,360.0,130998,011.3,E*62\r\n";
  // What is sent before a line is opened is dropped, so the device sends until it was heard.
  std::atomic<bool> done{false};
  std::thread device{[&] {
    const Bytes bytes(line.begin(), line.end());
    while (!done) {
      static_cast<void>(pty.value()->write_some(bytes));
      std::this_thread::yield();
    }
  }};
  const auto heard = listen(pty.value()->path(), clock, 20s);
  done = true;
  device.join();

  ASSERT_TRUE(heard) << heard.error().text();
  ASSERT_NE(heard->device, nullptr);
  EXPECT_EQ(heard->device->name, "GPS receiver (NMEA 0183)");
  const auto written = pty.value()->read();
  EXPECT_TRUE(!written || written->empty());
}

TEST(Listening, a_line_that_cannot_be_opened_is_explained) {
  const SystemClock clock;
  const auto heard = listen("/dev/no_such_line", clock, 1ms);
  ASSERT_FALSE(heard);
  EXPECT_EQ(heard.error().what, "no such device");
}

}  // namespace
}  // namespace nacelle::doctor
