// SPDX-License-Identifier: Apache-2.0
// What holds for every component of the tree.
#include <gtest/gtest.h>

#include <filesystem>
#include <rcl_interfaces/srv/get_parameter_types.hpp>
#include <rcl_interfaces/srv/list_parameters.hpp>

#include "asking.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {
namespace {

using rcl_interfaces::srv::GetParameterTypes;
using rcl_interfaces::srv::ListParameters;

std::vector<std::string> our_components() {
  std::vector<std::string> names;
  for (const auto& entry : PluginIndex{{test::component_folder()}}.entries()) {
    const std::string file = std::filesystem::path(entry.file).filename().string();
    const bool is_of_a_test = file.starts_with("nacelle_test_") || file.starts_with("nacelle_soak_");
    if (!is_of_a_test) names.push_back(entry.class_name);
  }
  return names;
}

class EveryComponent : public ::testing::TestWithParam<std::string> {};

// rcl_interfaces cannot distinguish such a parameter from a missing one: `ros2 param dump` prints {} for the whole node.
TEST_P(EveryComponent, has_no_parameter_without_a_value) {
  const SystemClock clock;
  ContainerOptions options;
  options.component_path = {test::component_folder()};
  options.node_interfaces = NodeInterfaces::All;
  Container container{std::move(options), clock};
  LoadRequest request;
  request.plugin = GetParam();
  const auto loaded = container.load(request);
  ASSERT_TRUE(loaded) << loaded.error().text();
  const std::string& node = loaded.value().node;
  const auto names = Call<ListParameters>{container, node + "/list_parameters", {}}.wait();
  ASSERT_TRUE(names && !names->result.names.empty());
  GetParameterTypes::Request request_types;
  request_types.names = names->result.names;
  const auto types = Call<GetParameterTypes>{container, node + "/get_parameter_types", request_types}.wait();
  ASSERT_TRUE(types && types->types.size() == names->result.names.size());
  for (std::size_t i = 0; i < types->types.size(); ++i)
    EXPECT_NE(types->types[i], static_cast<int>(ParameterType::NotSet)) << names->result.names[i];
}

INSTANTIATE_TEST_SUITE_P(OfTheTree, EveryComponent, ::testing::ValuesIn(our_components()),
                         [](const ::testing::TestParamInfo<std::string>& one) {
                           return one.param.substr(one.param.rfind(':') + 1);
                         });

TEST(EveryComponentOfTheTree, is_looked_at) { EXPECT_GE(our_components().size(), 10U); }

}  // namespace
}  // namespace nacelle::runtime
