// SPDX-License-Identifier: Apache-2.0
#include "session/run_texts.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace nacelle::session {
namespace {

TEST(RunTexts, name_a_file_by_its_path_from_the_launch_file) {
  const RunText file = file_text("launch/robot.launch.yaml", "launch/config/robot.yaml", "a: 1\n");
  EXPECT_EQ(file.name, "config/robot.yaml");
  EXPECT_EQ(file.media_type, "application/yaml");
  EXPECT_EQ(file.text, "a: 1\n");
  EXPECT_EQ(file_text("launch/robot.launch.yaml", "launch/robot.launch.yaml", "").name, "robot.launch.yaml");
  const std::string whole = (std::filesystem::current_path() / "launch/./config/robot.yaml").string();
  EXPECT_EQ(file_text("launch/robot.launch.yaml", whole, "").name, "config/robot.yaml");
}

TEST(RunTexts, name_a_file_that_is_elsewhere_by_its_whole_path) {
  const RunText file = file_text("/opt/robot/robot.launch.xml", "/opt/arm/arm.launch.xml", "");
  EXPECT_EQ(file.name, "/opt/arm/arm.launch.xml");
  EXPECT_EQ(file.media_type, "application/xml");
}

TEST(RunTexts, have_nothing_of_an_empty_container) {
  const SystemClock clock;
  const runtime::Container container{runtime::ContainerOptions{}, clock};
  const RunText parameters = parameters_text(container);
  EXPECT_EQ(parameters.name, "parameters.yaml");
  EXPECT_EQ(parameters.text, "");
}

}  // namespace
}  // namespace nacelle::session
