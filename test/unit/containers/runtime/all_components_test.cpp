// SPDX-License-Identifier: Apache-2.0
// What holds for every component of the tree.
#include <gtest/gtest.h>

#include <filesystem>
#include <future>

#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/plugin_library.hpp"

namespace nacelle::runtime {
namespace {

std::vector<std::string> our_components() {
  std::vector<std::string> names;
  for (const auto& entry : PluginIndex{{NACELLE_TEST_PLUGINS}}.entries()) {
    const std::string file = std::filesystem::path(entry.file).filename().string();
    const bool is_of_a_test = file.starts_with("nacelle_test_") || file.starts_with("nacelle_soak_");
    if (!is_of_a_test) names.push_back(entry.class_name);
  }
  return names;
}

class EveryComponent : public ::testing::TestWithParam<std::string> {};

// rcl_interfaces cannot tell such a parameter from one that is not there: `ros2 param dump` prints {} for the whole node.
TEST_P(EveryComponent, has_no_parameter_without_a_value) {
  const SystemClock clock;
  ContainerOptions options;
  options.component_path = {NACELLE_TEST_PLUGINS};
  Container container{std::move(options), clock};
  LoadRequest request;
  request.plugin = GetParam();
  const auto loaded = container.load(request);
  ASSERT_TRUE(loaded) << loaded.error().text();
  const auto asker = std::make_shared<int>();
  std::promise<std::vector<ParameterReport>> told;
  container.read_parameters(loaded.value().id, asker, [&](auto all) {
    EXPECT_TRUE(all);
    told.set_value(all ? std::move(all).value() : std::vector<ParameterReport>{});
  });
  const auto parameters = told.get_future().get();
  EXPECT_FALSE(parameters.empty());
  for (const auto& parameter : parameters) EXPECT_NE(type_of(parameter.value), ParameterType::NotSet) << parameter.name;
}

INSTANTIATE_TEST_SUITE_P(OfTheTree, EveryComponent, ::testing::ValuesIn(our_components()),
                         [](const ::testing::TestParamInfo<std::string>& one) {
                           return one.param.substr(one.param.rfind(':') + 1);
                         });

TEST(EveryComponentOfTheTree, is_looked_at) { EXPECT_GE(our_components().size(), 10U); }

}  // namespace
}  // namespace nacelle::runtime
