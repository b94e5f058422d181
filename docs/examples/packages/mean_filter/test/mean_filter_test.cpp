// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <std_msgs/msg/float64.hpp>
#include <utility>

#include "nacelle/runtime/test_container.hpp"

namespace example {

TEST(MeanFilter, publishes_the_mean_of_its_window) {
  nacelle::runtime::TestContainer container;
  auto mean = container.subscribe<std_msgs::msg::Float64>("/mean", nacelle::QoS(10));
  auto raw = container.advertise<std_msgs::msg::Float64>("/raw", nacelle::QoS(10));
  container.start("example::MeanFilter", {{"window", std::int64_t{2}}});

  raw.publish({.data = std::numeric_limits<double>::quiet_NaN()});  // ignored
  for (const auto& [value, expected] : {std::pair{1.0, 1.0}, {3.0, 2.0}, {5.0, 4.0}}) {
    raw.publish({.data = value});
    EXPECT_EQ(mean.next().data, expected);
  }
}

}  // namespace example
