// SPDX-License-Identifier: Apache-2.0
#include "look/model/access.hpp"

#include <gtest/gtest.h>

#include "look/model/service_rights.hpp"

namespace nacelle::look {
namespace {

const Access& access() {
  static const Access made{{"look", "drive", {"robot", "Robot.local"}, {"https://app.foxglove.dev"}}};
  return made;
}

TEST(Access, a_token_gives_its_right) {
  EXPECT_EQ(access().right_of("look"), Right::View);
  EXPECT_EQ(access().right_of("drive"), Right::Operate);
  for (const char* const wrong : {"", "loo", "look ", "Look", "drivE"})
    EXPECT_EQ(access().right_of(wrong), Right::None) << wrong;
  const Access without{{"", "", {}, {}}};
  EXPECT_EQ(without.right_of(""), Right::None) << "no token is no key";
}

TEST(Access, addresses_and_names_of_this_machine_are_its_hosts) {
  for (const char* const host :
       {"127.0.0.1:8080", "localhost", "LOCALHOST:80", "[::1]:8080", "192.168.1.7:8080", "robot:8080", "robot.local"})
    EXPECT_TRUE(access().is_host_allowed(host)) << host;
  for (const char* const host :
       {"", ":8080", "evil.example", "127.0.0.1.evil.example:8080", "robot.evil", "[::1", "0x7f000001"})
    EXPECT_FALSE(access().is_host_allowed(host)) << host;
}

TEST(Access, pages_of_other_sites_are_shut_out) {
  EXPECT_TRUE(access().is_origin_allowed("", "127.0.0.1:8080")) << "no browser";
  EXPECT_TRUE(access().is_origin_allowed("http://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_TRUE(access().is_origin_allowed("https://app.foxglove.dev", "127.0.0.1:8080"));
  for (const char* const origin : {"http://127.0.0.1:8081", "https://127.0.0.1:8080", "http://evil.example", "null",
                                   "file://", "https://app.foxglove.dev.evil"})
    EXPECT_FALSE(access().is_origin_allowed(origin, "127.0.0.1:8080")) << origin;
}

TEST(ServiceRights, services_that_only_answer_need_view_and_all_others_operate) {
  for (const char* const type : {"rcl_interfaces/srv/GetParameters_Request", "rcl_interfaces/srv/ListParameters",
                                 "lifecycle_msgs/srv/GetState", "nacelle_interfaces/srv/GetStatistics_Request",
                                 "composition_interfaces/srv/ListNodes", "rosbag2_interfaces/srv/IsPaused"})
    EXPECT_EQ(right_for_service(type), Right::View) << type;
  for (const char* const type : {"rcl_interfaces/srv/SetParameters", "lifecycle_msgs/srv/ChangeState",
                                 "std_srvs/srv/Trigger", "nacelle_interfaces/srv/ReleaseEmergencyStops",
                                 "composition_interfaces/srv/LoadNode", "foreign_msgs/srv/GetAndForget", "", "Get"})
    EXPECT_EQ(right_for_service(type), Right::Operate) << type;
}

TEST(ServiceRights, no_page_ends_the_robot_or_opens_its_network) {
  EXPECT_EQ(right_for_service("nacelle_interfaces/srv/Shutdown_Request"), Right::None);
  EXPECT_EQ(right_for_service("nacelle_interfaces/srv/SetNetwork"), Right::None);
}

}  // namespace
}  // namespace nacelle::look
