// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/problem_json.hpp"

namespace nacelle {
namespace kitchen {

enum class Mishap { Burnt, Salty };
constexpr const char* code_text(Mishap mishap) { return mishap == Mishap::Burnt ? "kitchen.burnt" : "kitchen.salty"; }

}  // namespace kitchen
namespace {

using kitchen::Mishap;

TEST(Place, says_what_it_has) {
  EXPECT_EQ(Place("container 'robot'").text(), "container 'robot'");
  EXPECT_EQ(Place("robot.launch.yaml", 12, 5).text(), "robot.launch.yaml:12");
  EXPECT_EQ(Place("robot.launch.yaml", 0).text(), "robot.launch.yaml");
  EXPECT_EQ(Place::of_node("/lidar").text(), "node /lidar");
  EXPECT_EQ(Place::of_parameter("port_name").text(), "parameter port_name");
  Place both = Place::of_parameter("port_name", "/lidar");
  EXPECT_EQ(both.text(), "node /lidar, parameter port_name");
  both.words = "/dev/ttyUSB0";
  EXPECT_EQ(both.text(), "node /lidar, parameter port_name: /dev/ttyUSB0");
  EXPECT_TRUE(Place{}.empty());
}

TEST(ProblemCode, is_its_text_in_this_process_and_in_another) {
  const Problem problem{"soup", "is black", "", Mishap::Burnt};
  EXPECT_EQ(problem.code, Mishap::Burnt);
  EXPECT_NE(problem.code, Mishap::Salty);
  EXPECT_EQ(problem.code, ProblemCode::from_text("kitchen.burnt"));
  EXPECT_TRUE((Problem{"soup", "is black", ""}).code.empty());
  EXPECT_EQ(problem.text(), "soup: is black");
}

TEST(ProblemJson, keeps_every_part) {
  Place of_a_parameter = Place::of_parameter("dish", "/cook");
  of_a_parameter.words = "table 4";
  for (const Place& where : {Place{}, Place{"soup"}, Place{"menu.yaml", 0}, Place{"menu.yaml", 12, 3},
                             Place::of_node("/cook"), Place::of_parameter("dish"), of_a_parameter}) {
    const Problem problem{where, "is black", "stir it", Mishap::Burnt, "coal"};
    EXPECT_EQ(nlohmann::json(problem).get<Problem>(), problem) << problem.text();
  }
  EXPECT_EQ(nlohmann::json(Problem{"soup", "is black", ""}),
            nlohmann::json({{"where", "soup"}, {"what", "is black"}, {"way_out", ""}}));
}

}  // namespace
}  // namespace nacelle
