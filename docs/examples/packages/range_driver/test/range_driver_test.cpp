// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <sensor_msgs/msg/range.hpp>
#include <string>

#include "nacelle/io/pty_pair.hpp"
#include "nacelle/runtime/test_container.hpp"

namespace example {

using namespace std::chrono_literals;

TEST(RangeDriver, reads_a_line_and_outlives_its_cable) {
  auto cable = nacelle::io::PtyPair::create();
  ASSERT_TRUE(cable);
  const std::string path = ::testing::TempDir() + "range_line_" + std::to_string(::getpid());
  ASSERT_TRUE(cable.value()->link_as(path));
  nacelle::runtime::TestContainer container;
  auto ranges = container.subscribe<sensor_msgs::msg::Range>("/range", nacelle::QoS(5).best_effort());
  container.start("example::RangeDriver", {{"port_name", path}});

  // The end of a distance, which the driver skips; no distance; a distance.
  ASSERT_NE(cable.value()->write_some(nacelle::as_bytes("34\n12x4\n1234\n")), 0U);
  const auto range = ranges.next();
  EXPECT_FLOAT_EQ(range.range, 1.234F);
  EXPECT_EQ(range.header.frame_id, "range_link");
  EXPECT_NE(range.header.stamp.sec, 0);

  cable.value()->hang_up();
  cable = nacelle::io::PtyPair::create();
  ASSERT_TRUE(cable);
  ASSERT_TRUE(cable.value()->link_as(path));
  // What comes before the driver has opened the line again is lost, as from a real device.
  do { static_cast<void>(cable.value()->write_some(nacelle::as_bytes("500\n"))); } while (!ranges.waits(50ms));
  EXPECT_FLOAT_EQ(ranges.next().range, 0.5F);
}

}  // namespace example
