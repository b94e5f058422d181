// SPDX-License-Identifier: Apache-2.0
#include "networking/refused_services.hpp"

#include <gmock/gmock.h>

#include <composition_interfaces/srv/load_node.hpp>
#include <nacelle_interfaces/srv/release_emergency_stops.hpp>
#include <vector>

namespace nacelle::networking {
namespace {

using composition_interfaces::srv::LoadNode;
using nacelle_interfaces::srv::ReleaseEmergencyStops;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<std::string> names_of(const transport_dds::NetworkSettings& settings) {
  std::vector<std::string> names;
  for (const auto& [name, response] : refused_services("/robot", settings)) names.push_back(name);
  return names;
}

TEST(RefusedServices, are_all_that_change_the_robot_by_default) {
  EXPECT_THAT(names_of({}),
              AllOf(Contains("/robot/_container/load_node"), Contains("/robot/_container/unload_component"),
                    Contains("/robot/_container/release_emergency_stops"), Contains("/robot/_container/shutdown")));
}

TEST(RefusedServices, name_the_way_out) {
  const auto refused = refused_services("/robot", {});
  const auto& load = *static_cast<const LoadNode::Response*>(refused.at("/robot/_container/load_node")->get());
  EXPECT_FALSE(load.success);
  EXPECT_THAT(load.error_message, HasSubstr("set `network: {allow_load: true}` in its launch file"));
  const std::string name = "/robot/_container/release_emergency_stops";
  const auto& release = *static_cast<const ReleaseEmergencyStops::Response*>(refused.at(name)->get());
  EXPECT_FALSE(release.success);
  EXPECT_EQ(release.problem.where, name);
  EXPECT_THAT(release.problem.way_out, HasSubstr("set `network: {remote_control: true}` in its launch file"));
}

TEST(RefusedServices, are_those_that_the_launch_file_leaves) {
  transport_dds::NetworkSettings settings;
  settings.allow_load = true;
  EXPECT_THAT(names_of(settings), ElementsAre("/robot/_container/release_emergency_stops",
                                              "/robot/_container/set_network", "/robot/_container/shutdown"));
  settings.remote_control = true;
  EXPECT_THAT(names_of(settings), IsEmpty());
  settings.allow_load = false;
  EXPECT_THAT(names_of(settings), SizeIs(4));
}

TEST(RefusedServices, leave_control_to_the_permissions_of_dds_security) {
  transport_dds::NetworkSettings settings;
  settings.secured.emplace();
  EXPECT_THAT(names_of(settings), SizeIs(4)) << "code is still loaded with allow_load only";
}

}  // namespace
}  // namespace nacelle::networking
