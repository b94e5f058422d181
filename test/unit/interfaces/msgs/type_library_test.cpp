// SPDX-License-Identifier: Apache-2.0
#include "msgs_test_support.hpp"
#include "support/places.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace nacelle {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

TEST(TypeLibrary, lists_the_packages_of_its_directories) {
  const auto packages = msgs::TypeLibrary{{test::message_libraries()}}.packages();

  EXPECT_THAT(packages, Contains("sensor_msgs"));
  EXPECT_THAT(packages, Not(Contains("json")));
  EXPECT_THAT(packages, Not(Contains("my_robot_msgs")));
}

TEST(TypeLibrary, also_searches_the_folders_of_the_environment) {
  ASSERT_EQ(setenv("NACELLE_INTERFACE_PATH", ("/nowhere::" + test::own_message_libraries()).c_str(), 1), 0);
  const auto packages = msgs::TypeLibrary{{test::message_libraries()}}.packages();
  unsetenv("NACELLE_INTERFACE_PATH");

  EXPECT_THAT(packages, Contains("my_robot_msgs"));
  EXPECT_THAT(packages, Contains("sensor_msgs"));
}

TEST(TypeLibrary, finds_libraries_that_have_a_version_in_their_name) {
  std::string pattern = testing::TempDir() + "nacelle-types-XXXXXX";
  ASSERT_NE(mkdtemp(pattern.data()), nullptr);
  const std::filesystem::path folder = pattern;
  const auto link = [&](const std::string& package, const std::string& name) {
    std::filesystem::create_symlink(test::message_libraries() + "/libnacelle_msgs_" + package + ".so", folder / name);
  };
  link("std_srvs", "libnacelle_msgs_std_srvs.so.0.1");
  link("std_msgs", "libnacelle_msgs_old_msgs.so.bak");
  link("std_msgs", "libnacelle_msgs_json.so.0.1");
  link("std_msgs", "libnacelle_msgs_std_msgs.so");
  link("absent", "libnacelle_msgs_std_msgs.so.0.0");

  msgs::TypeLibrary library{{folder}};

  EXPECT_THAT(library.packages(), testing::ElementsAre("std_msgs", "std_srvs"));
  EXPECT_TRUE(library.find("std_srvs/srv/Empty"));
  EXPECT_TRUE(library.find("std_msgs/msg/String"));
  std::filesystem::remove_all(folder);
}

TEST(TypeLibrary, lists_wholes_and_on_request_their_parts) {
  const auto wholes = test::type_library().names("std_srvs", false);
  const auto parts = test::type_library().names("std_srvs", true);

  EXPECT_THAT(*wholes, testing::ElementsAre("std_srvs/srv/Empty", "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"));
  EXPECT_THAT(*parts, Contains("std_srvs/srv/SetBool_Request"));
  EXPECT_THAT(*parts, Contains("std_srvs/srv/SetBool_Event"));
}

TEST(TypeLibrary, knows_the_parts_of_an_action) {
  for (const char* part :
       {"_Goal", "_Result", "_Feedback", "_FeedbackMessage", "_SendGoal_Request", "_SendGoal_Response",
        "_SendGoal_Event", "_GetResult_Request", "_GetResult_Response", "_GetResult_Event"}) {
    const auto found = test::type_library().message("tf2_msgs/action/LookupTransform" + std::string(part));
    EXPECT_TRUE(found) << found.error().text();
  }
  EXPECT_NE(test::type_library().find("tf2_msgs/action/LookupTransform")->action, nullptr);
  EXPECT_NE(test::type_library().find("tf2_msgs/action/LookupTransform_SendGoal")->service, nullptr);
}

TEST(TypeLibrary, names_the_nearest_type_for_a_wrong_one) {
  EXPECT_THAT(test::type_library().find("sensor_msgs/msg/Imgae").error().text(), HasSubstr("'sensor_msgs/msg/Image'"));
  EXPECT_THAT(test::type_library().find("sensor_msg/msg/Image").error().text(), HasSubstr("'sensor_msgs/msg/Image'"));
  EXPECT_THAT(test::type_library().find("std_msgs/String").error().text(), HasSubstr("'std_msgs/msg/String'"));
  EXPECT_THAT(test::type_library().find("").error().text(), HasSubstr("interface list"));
}

TEST(TypeLibrary, says_which_messages_a_service_has) {
  const auto found = test::type_library().message("std_srvs/srv/SetBool");

  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().text(), HasSubstr("std_srvs/srv/SetBool_Request"));
}

TEST(TypeLibrary, names_the_nearest_package_for_a_wrong_one) {
  EXPECT_THAT(test::type_library().package("sensor_mgs").error().text(), HasSubstr("'sensor_msgs'"));
  EXPECT_THAT(msgs::TypeLibrary{{"/nowhere"}}.package("std_msgs").error().text(), HasSubstr("NACELLE_INTERFACE_PATH"));
}

}  // namespace
}  // namespace nacelle
