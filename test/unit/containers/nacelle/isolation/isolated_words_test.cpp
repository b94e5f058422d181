// SPDX-License-Identifier: Apache-2.0
#include "isolation/isolated_words.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace nacelle::isolation {
namespace {

TEST(IsolatedWords, carry_what_a_component_is) {
  runtime::ComponentInfo info{0,   "/n", "a::B", "/lib/x.so", StateId::Active, true, {"CODE", "text"}, {"a warning"},
                              true};
  info.other_nodes = {"/beside"};
  const auto came = info_from_json(nlohmann::json::parse(info_to_json(info).dump()));
  EXPECT_EQ(came.node + came.plugin + came.library, info.node + info.plugin + info.library);
  EXPECT_EQ(came.state, info.state);
  EXPECT_EQ(came.fault.code + came.fault.text, "CODEtext");
  EXPECT_EQ(came.warnings, info.warnings);
  EXPECT_TRUE(came.actuator);
  EXPECT_EQ(came.other_nodes, info.other_nodes);
}

}  // namespace
}  // namespace nacelle::isolation
