// SPDX-License-Identifier: Apache-2.0
#include "reference/declarations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "nacelle/runtime/plugin_library.hpp"
#include "reference/markdown.hpp"
#include "support/places.hpp"

namespace nacelle::reference {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class Declarations : public ::testing::Test {
 protected:
  Result<json, Problem> of(const std::string& name) {
    loading::ProgramPlaces places;
    places.component_folders = {test::component_folder()};
    const auto entry = runtime::PluginIndex{places.component_folders}.find(name);
    EXPECT_TRUE(entry) << name;
    return declarations_of(entry.value(), places, clock_);
  }
  json documented() {
    auto all = of("nacelle::test::Documented");
    EXPECT_TRUE(all) << all.error().text();
    return std::move(all).value();
  }
  SystemClock clock_;
};

json names(const json& rows) {
  json all = json::array();
  for (const json& row : rows) all.push_back(row["name"]);
  return all;
}

TEST_F(Declarations, give_names_as_the_class_wrote_them_and_each_row_once) {
  const json all = documented();

  EXPECT_EQ(all["plugin"], "nacelle::test::Documented");
  EXPECT_EQ(all["node"], "documented");
  EXPECT_EQ(all["managed"], false);
  EXPECT_EQ(names(all["publishes"]), json::array({"relative"}));
  EXPECT_EQ(all["publishes"][0]["qos_text"], "keep_last 7, reliable, volatile");
  EXPECT_EQ(names(all["subscribes"]), json::array({"documented/relative", "~/own"}))
      << "the node's name does not make it private";
  EXPECT_EQ(all["services"], json::parse(R"([{"name": "go", "type": "std_srvs/srv/Trigger"}])"));
  EXPECT_EQ(all["clients"], json::parse(R"([{"name": "/other/go", "type": "std_srvs/srv/Trigger"}])"));
  EXPECT_EQ(all["actions"], json::parse(R"([{"name": "~/series", "type": "example_interfaces/action/Fibonacci"}])"));
  EXPECT_EQ(all["transforms"][0]["child"], "b");
  EXPECT_EQ(all["transforms"][0]["if_no_other_node_does"], true);
  EXPECT_EQ(all["devices"], json::array({"line"}));
}

TEST_F(Declarations, give_parameters_with_type_default_and_range) {
  json rows = json::object();
  const json all = documented();
  for (const json& row : all["parameters"]) rows[row["name"].get<std::string>()] = row;

  EXPECT_EQ(rows["speed"]["type"], "double");
  EXPECT_EQ(rows["speed"]["default"], "1.5");
  EXPECT_EQ(rows["speed"]["range"], json::parse(R"({"from": 0.0, "to": 2.0, "step": 0.5})"));
  EXPECT_EQ(rows["speed"]["read_only"], true);
  EXPECT_EQ(rows["count"]["read_only"], false);
  EXPECT_EQ(rows["count"]["range"]["to"], 9);
  EXPECT_EQ(rows["line"]["type"], "string") << "as declared: it is not set";
  EXPECT_EQ(rows["line"]["default"], nullptr);
}

TEST_F(Declarations, give_what_the_class_has_with_parameters_only_apart) {
  const json all = documented();

  EXPECT_EQ(all["with_parameters"], json::array({"more:=true"}));
  EXPECT_EQ(names(all["also"]["publishes"]), json::array({"/all"}));
  EXPECT_EQ(names(all["also"]["parameters"]), json::array({"extra"}));
  EXPECT_TRUE(all["also"]["services"].empty());
}

TEST_F(Declarations, refuse_a_line_that_is_no_parameter) {
  const auto all = of("nacelle::test::WronglyDocumented");

  ASSERT_FALSE(all);
  EXPECT_THAT(all.error().text(), HasSubstr("ComponentAbout::also_with has the line 'more=true'"));
}

TEST_F(Declarations, are_written_as_tables) {
  const std::string page = markdown_of(documented());

  EXPECT_THAT(page,
              HasSubstr("## nacelle::test::Documented\n\nShows everything.\n\nPackage `nacelle_test_documented`, node "
                        "`documented`. Devices: a zero sink (parameter `line`).\n"));
  EXPECT_THAT(page, HasSubstr("| Publishes | Type | QoS |\n| --- | --- | --- |\n| `relative` | `std_msgs/msg/Bool` |"));
  EXPECT_THAT(page, HasSubstr("| `a` -> `b` | no other node does, as `more` says |"));
  EXPECT_THAT(page,
              HasSubstr("| `speed` | double | `1.5` | 0 to 2 in steps of 0.5 | yes | m/s\\|forwards (not &lt;0>) |"));
  EXPECT_THAT(page, HasSubstr("| `line` | string |  |  |  |  |"));
  EXPECT_THAT(page, HasSubstr("\nWith `more:=true` it also has:\n\n| Publishes |"));
}

}  // namespace
}  // namespace nacelle::reference
