// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nacelle/node/component.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/plugin_fault.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "nacelle/runtime/test_container.hpp"

namespace nacelle::runtime {
namespace {

using ::testing::EndsWith;
using ::testing::StartsWith;

class ComponentAbi : public ::testing::TestWithParam<const char*> {};

TEST_P(ComponentAbi, of_another_version_is_refused_by_name_with_both_numbers) {
  TestContainer robot;
  LoadRequest request;
  request.plugin = GetParam();

  const auto loaded = robot.container().load(request);

  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, PluginFault::OtherAbi);
  EXPECT_EQ(loaded.error().where, Place(GetParam()));
  EXPECT_THAT(loaded.error().text(), StartsWith(std::string{GetParam()} + ": /"));
  EXPECT_THAT(loaded.error().text(),
              EndsWith(".so was built for component ABI 48, this container has " + std::to_string(kComponentAbi) +
                       "; build it again with the headers of this version"));
  EXPECT_FALSE(PluginLibrary::is_mapped(loaded.error().value));
  EXPECT_TRUE(robot.container().list().empty());
  EXPECT_EQ(robot.start("nacelle::test::Talker").state, StateId::Active) << "the container goes on";
}

INSTANTIATE_TEST_SUITE_P(Libraries, ComponentAbi,
                         ::testing::Values("nacelle::test::OtherAbi", "nacelle::test::OtherAbiUnlinked"));

}  // namespace
}  // namespace nacelle::runtime
