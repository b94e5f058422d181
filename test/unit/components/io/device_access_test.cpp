// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/device_access.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>

namespace nacelle::io {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A machine's files in a folder.
class DeviceAccessTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path{::testing::TempDir()} / ("device_access_" + std::to_string(::getpid()));
    fs::create_directories(root_ / "dev/serial/by-id");
    fs::create_directories(root_ / "proc");
  }
  void TearDown() override { fs::remove_all(root_); }

  void device(const std::string& name) { std::ofstream{root_ / "dev" / name}; }
  void process(int pid, const std::string& name, const std::string& open_file) {
    const fs::path folder = root_ / "proc" / std::to_string(pid);
    fs::create_directories(folder / "fd");
    std::ofstream{folder / "comm"} << name << "\n";
    fs::create_symlink(open_file, folder / "fd/7");
  }
  fs::path root_;
};

TEST_F(DeviceAccessTest, names_the_programs_that_have_a_device_open) {
  process(41, "cat", "/dev/ttyUSB0");
  process(7, "modem", "/dev/ttyUSB0");
  process(8, "other", "/dev/ttyUSB1");
  process(9, "nacelle_watcher", "/dev/ttyUSB0");

  const auto holders = holders_of("/dev/ttyUSB0", root_);

  EXPECT_THAT(holders, ElementsAre(Process{7, "modem"}, Process{41, "cat"}));
  EXPECT_EQ(names_of(holders), "modem (pid 7), cat (pid 41)");
}

TEST_F(DeviceAccessTest, a_busy_device_is_explained_by_the_program_that_has_it) {
  process(41, "cat", "/dev/ttyUSB0");

  const Problem problem = why_not_opened("/dev/ttyUSB0", EBUSY, root_);

  EXPECT_EQ(problem.what, "in use by cat (pid 41)");
  EXPECT_EQ(problem.way_out, "end it: kill 41");
}

TEST_F(DeviceAccessTest, modem_manager_is_switched_off_and_not_killed) {
  process(41, "ModemManager", "/dev/ttyACM0");

  EXPECT_THAT(why_not_opened("/dev/ttyACM0", EBUSY, root_).way_out, HasSubstr("systemctl disable"));
}

TEST_F(DeviceAccessTest, a_program_of_another_user_is_left_to_fuser) {
  EXPECT_THAT(why_not_opened("/dev/ttyUSB0", EBUSY, root_).way_out, HasSubstr("sudo fuser -v /dev/ttyUSB0"));
}

TEST_F(DeviceAccessTest, a_missing_permission_names_the_group) {
  device("ttyUSB0");
  fs::permissions(root_ / "dev/ttyUSB0", fs::perms::owner_all | fs::perms::group_read | fs::perms::group_write);
  ASSERT_EQ(::chown((root_ / "dev/ttyUSB0").c_str(), static_cast<uid_t>(-1), ::getegid()), 0);

  const Problem problem = why_not_opened("/dev/ttyUSB0", EACCES, root_);

  EXPECT_THAT(problem.what, HasSubstr("no permission"));
  EXPECT_THAT(problem.way_out, HasSubstr("usermod -aG"));
}

TEST_F(DeviceAccessTest, a_device_without_rights_for_its_group_needs_a_rule) {
  device("ttyUSB0");
  fs::permissions(root_ / "dev/ttyUSB0", fs::perms::owner_all);

  EXPECT_THAT(why_not_opened("/dev/ttyUSB0", EACCES, root_).way_out, HasSubstr("udev rule"));
}

TEST_F(DeviceAccessTest, an_absent_device_is_answered_with_those_that_are_there) {
  device("ttyUSB3");
  device("ttyACM0");
  device("ttyS0");
  fs::create_symlink("../../ttyUSB3", root_ / "dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00");

  EXPECT_THAT(serial_devices(root_),
              ElementsAre("/dev/serial/by-id/usb-Silicon_Labs_CP2102_0001-if00", "/dev/ttyACM0"));
  EXPECT_THAT(why_not_opened("/dev/ttyUSB0", ENOENT, root_).way_out, HasSubstr("There are /dev/serial/by-id/usb-Sil"));
  EXPECT_THAT(why_not_opened("/dev/video0", ENOENT, root_).way_out, ::testing::Not(HasSubstr("There are")));
}

}  // namespace
}  // namespace nacelle::io
