// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "machine_of_files.hpp"

namespace nacelle::doctor {
namespace {

using testing::HasSubstr;
using Devices = MachineOfFiles;

TEST_F(Devices, a_machine_with_nothing_plugged_in_is_fine) {
  plug_in("/dev/ttyS0");  // a PC's board has them with or without a chip

  const Finding found = find(check_devices, "/dev");

  EXPECT_EQ(found.severity, Severity::Fine);
  EXPECT_THAT(found.value, HasSubstr("no camera and no serial line"));
}

TEST_F(Devices, a_device_of_another_group_is_reported_with_the_group_to_join) {
  plug_in("/dev/ttyUSB0");

  const Finding found = find(check_devices, "/dev/ttyUSB0");

  EXPECT_EQ(found.severity, Severity::Wrong);
  EXPECT_EQ(found.value, "rwrw-- of group dialout");
  EXPECT_EQ(found.problem.what, "this user may not open it");
  EXPECT_EQ(found.problem.way_out, "sudo usermod -aG dialout $USER, then log in again");
}

TEST_F(Devices, a_member_of_the_group_may_open_it) {
  plug_in("/dev/ttyUSB0");
  join_group(::getgid());
  EXPECT_EQ(find(check_devices, "/dev/ttyUSB0").severity, Severity::Fine);
}

TEST_F(Devices, a_group_without_rights_is_not_one_to_join) {
  plug_in("/dev/ttyACM0", 0600);
  const Finding found = find(check_devices, "/dev/ttyACM0");
  EXPECT_EQ(found.severity, Severity::Wrong);
  EXPECT_THAT(found.problem.way_out, HasSubstr("udev"));
}

TEST_F(Devices, a_device_that_another_program_reads_is_reported_with_its_name_and_pid) {
  plug_in("/dev/ttyUSB0", 0666);
  run(812, "ModemManager", "/dev/ttyUSB0");
  run(14, "bash", "/dev/pts/0");
  EXPECT_EQ(find(check_devices, "/dev/ttyUSB0").severity, Severity::Advice)
      << "no parameter of the robot names this device";

  wanted.devices = {{"/dev/ttyUSB0", "/lidar, parameter port_name"}};
  const Finding found = find(check_devices, "/dev/ttyUSB0 (/lidar, parameter port_name)");

  EXPECT_EQ(found.severity, Severity::Wrong);
  EXPECT_THAT(found.value, HasSubstr("held by ModemManager (pid 812)"));
  EXPECT_THAT(found.problem.way_out, HasSubstr("systemctl disable --now ModemManager"));
}

TEST_F(Devices, a_device_that_nacelle_itself_reads_is_fine) {
  plug_in("/dev/ttyUSB0", 0666);
  run(99, "nacelle", "/dev/ttyUSB0");
  run(100, "nacelle_watcher", "/dev/ttyUSB0");  // shares the open files of the first
  wanted.devices = {{"/dev/ttyUSB0", "/lidar, parameter port_name"}};
  EXPECT_EQ(find(check_devices, "/dev/ttyUSB0").severity, Severity::Fine);
}

TEST_F(Devices, a_link_by_id_is_followed) {
  plug_in("/dev/ttyUSB1", 0666);
  std::filesystem::create_directories(at("/dev/serial/by-id"));
  std::filesystem::create_symlink("../../ttyUSB1", at("/dev/serial/by-id/usb-lidar"));
  run(7, "cat", "/dev/ttyUSB1");
  wanted.devices = {{"/dev/serial/by-id/usb-lidar", "/lidar, parameter port_name"}};

  const Finding found = find(check_devices, "/dev/serial/by-id/usb-lidar");

  EXPECT_THAT(found.value, HasSubstr("-> /dev/ttyUSB1"));
  EXPECT_EQ(found.problem.way_out, "end it: kill 7");
}

TEST_F(Devices, a_missing_device_is_reported_with_the_present_ones) {
  plug_in("/dev/ttyUSB1", 0666);
  plug_in("/dev/video0", 0666);
  wanted.devices = {{"/dev/ttyUSB0", "/lidar, parameter port_name"},
                    {"/dev/video4", "/camera, parameter video_device"}};

  EXPECT_THAT(find(check_devices, "/dev/ttyUSB0").text(), HasSubstr("is not there; there are /dev/ttyUSB1; give that"));
  EXPECT_THAT(find(check_devices, "/dev/video4").text(), HasSubstr("there are /dev/video0;"));
}

TEST_F(Devices, a_launch_files_parameters_name_them) {
  launch::Plan plan;
  launch::ComponentPlan lidar;
  lidar.name = "lidar";
  lidar.namespace_ = "/";
  lidar.parameters = {{"port_name", std::string{"/dev/ttyUSB3"}, {}},
                      {"frame_id", std::string{"laser"}, {}},
                      {"baud", std::int64_t{9600}, {}}};
  lidar.thread.priority = 40;
  plan.components = {lidar};

  const Wanted all = wanted_by(plan);

  ASSERT_EQ(all.devices.size(), 1U);
  EXPECT_EQ(all.devices[0].path, "/dev/ttyUSB3");
  EXPECT_EQ(all.devices[0].by, "/lidar, parameter port_name");
  ASSERT_EQ(all.priorities.size(), 1U);
  EXPECT_EQ(all.priorities[0].priority, 40);
  EXPECT_FALSE(all.shares_memory);
}

}  // namespace
}  // namespace nacelle::doctor
