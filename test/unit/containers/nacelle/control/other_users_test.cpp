// SPDX-License-Identifier: Apache-2.0
#include "control/other_users.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::control {
namespace {

constexpr const char* kSockets =
    "Num       RefCount Protocol Flags    Type St Inode Path\n"
    "0000000000000000: 00000002 00000000 00010000 0001 01 1001 /run/user/1001/nacelle/robot.sock\n"
    "0000000000000000: 00000003 00000000 00000000 0001 03 1002 /run/user/1001/nacelle/robot.sock\n"
    "0000000000000000: 00000002 00000000 00010000 0001 01 1003 /dev/shm/nacelle-4000000001/arm.sock\n"
    "0000000000000000: 00000002 00000000 00010000 0001 01 1004 /run/user/1000/nacelle/mine.sock\n"
    "0000000000000000: 00000002 00000000 00010000 0001 01 1005 /dev/shm/nacelle-1001/\x1b[2J.sock\n"
    "0000000000000000: 00000002 00000000 00010000 0001 01 1006 /run/user/1001/bus\n"
    "0000000000000000: 00000002 00000000 00010000 0001 01 1007 @/tmp/.X11-unix/X0\n";

TEST(OtherUsers, containers_that_listen_are_found_by_the_paths_of_their_sockets) {
  EXPECT_THAT(
      containers_of_others(kSockets, 1000),
      testing::ElementsAre(OthersContainer{"robot", 1001, "/run/user/1001"}, OthersContainer{"arm", 4000000001U, ""}));
  EXPECT_TRUE(containers_of_others("", 1000).empty());
}

TEST(OtherUsers, a_service_is_open_to_its_group) {
  const auto found = containers_of_others(
      "0000000000000000: 00000002 00000000 00010000 0001 01 1001 /run/nacelle/robot.sock\n"
      "0000000000000000: 00000002 00000000 00010000 0001 01 1002 /run/nacelle/other.lock\n",
      0);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(
      problem_of_others(found).text(),
      "no container of yours is running; the service nacelle@robot runs; join its group: sudo usermod -aG nacelle "
      "$USER, then log in again");
}

TEST(OtherUsers, the_problem_names_them_and_how_to_reach_them) {
  EXPECT_EQ(problem_of_others({{"arm", 4000000001U, ""}}).text(),
            "no container of yours is running; user #4000000001 runs 'arm'; ask as its user: sudo -u '#4000000001' "
            "nacelle ...");
  EXPECT_THAT(problem_of_others({{"robot", 4000000001U, "/run/user/4000000001"}}).way_out,
              testing::HasSubstr("XDG_RUNTIME_DIR=/run/user/4000000001 nacelle"));
}

}  // namespace
}  // namespace nacelle::control
