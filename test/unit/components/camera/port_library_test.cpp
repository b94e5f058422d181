// SPDX-License-Identifier: Apache-2.0
#include "camera/port/port_library.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "camera/port/camera_fault.hpp"

namespace nacelle::camera {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

TEST(PortLibrary, is_expected_beside_the_base_library) {
  const std::string path = port_library_path("libcamera");
  EXPECT_THAT(path, EndsWith("/nacelle/ports/libcamera.so"));
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path{path}.parent_path().parent_path().parent_path() /
                                      "libnacelle_base.so"));
}

TEST(PortLibrary, that_is_absent_is_a_port_that_says_so) {
  const SystemClock clock;
  const auto port = make_port_of("/no/such/libcamera.so", clock);
  CaptureWish wish;
  wish.device = "libcamera:imx219";
  const auto refused = port->open(wish);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, CameraFault::NotInstalled);
  EXPECT_EQ(refused.error().where, Place{"libcamera:imx219"});
  EXPECT_THAT(refused.error().text(), HasSubstr("/no/such/libcamera.so"));
  EXPECT_THAT(refused.error().way_out, HasSubstr("nacelle-libcamera"));
  EXPECT_FALSE(port->start());
  EXPECT_TRUE(port->controls().empty());
  port->interrupt();
  port->close();
}

TEST(PortLibrary, that_is_another_library_is_refused) {
  const SystemClock clock;
  const std::filesystem::path folder =
      std::filesystem::path{port_library_path("x")}.parent_path().parent_path().parent_path();
  const auto port = make_port_of((folder / "libnacelle_base.so").string(), clock);
  const auto refused = port->open({});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, CameraFault::NotInstalled);
  EXPECT_THAT(refused.error().what, HasSubstr("is no port of a camera"));
}

}  // namespace
}  // namespace nacelle::camera
