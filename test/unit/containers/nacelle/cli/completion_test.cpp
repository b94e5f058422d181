// SPDX-License-Identifier: Apache-2.0
#include "cli/completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::cli {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A small program like ours.
struct Completion : ::testing::Test {
  Completion() {
    Command& topic = root.add("topic", "topics");
    Command& echo = topic.add("echo", "show messages");
    echo.option("topic", text, "").required().names_a(Names::Topic);
    echo.option("--container", text, "which container");
    echo.option("-f,--field", text, "one field only");
    echo.flag("--json", flag, "as JSON");
    echo.flag("--secret", flag, "").hidden();
    topic.add("list", "the topics");
    Command& set = root.add("param", "parameters").add("set", "set one");
    set.option("node", text, "").names_a(Names::Node);
    set.option("name", text, "").names_a(Names::Parameter);
    set.option("--as", text, "").one_of({"int", "text"});
    root.add("load", "load").option("plugins", list, "").names_a(Names::Plugin);
    root.add("launch", "start").option("file", text, "").names_a(Names::File);
    Command& about = root.add("about", "about one");
    about.option("node", text, "").names_a(Names::Node).names_a_with("--doc", Names::Plugin);
    about.flag("--doc", flag, "");
    Command& check = root.add("inspect", "a command with another below it");
    check.option("what", text, "").one_of({"net_card", "disk"});
    check.flag("--all", flag, "");
    check.runs([] { return 0; });
    check.add("net", "the network");
    root.add("isolated", "not for people").hidden();
  }
  std::vector<std::string> at(std::vector<std::string> words) {
    std::vector<std::string> found;
    const auto ask = [this](const NameQuestion& question) -> std::vector<std::string> {
      asked = question;
      switch (question.names) {
        case Names::Topic: return {"/scan", "/scan_filtered", "/odom"};
        case Names::Node: return {"/lidar", "/camera"};
        case Names::Parameter: return {"rate", "frame_id"};
        case Names::Plugin: return {"nacelle::lidar::Lidar", "nacelle::imu::Imu"};
        default: return {};
      }
    };
    for (const auto& candidate : completions(root, std::move(words), ask, [] {
           return std::vector<std::string>{"robot", "arm"};
         }))
      found.push_back(candidate.word);
    return found;
  }

  Command root{"nacelle", "Nacelle: a test"};
  std::string text;
  std::vector<std::string> list;
  bool flag = false;
  NameQuestion asked;
};

TEST_F(Completion, offers_the_commands_that_are_for_people) {
  EXPECT_THAT(at({""}), ElementsAre("topic", "param", "load", "launch", "about", "inspect"));
  EXPECT_THAT(at({"l"}), ElementsAre("load", "launch"));
  EXPECT_THAT(at({"topic", ""}), ElementsAre("echo", "list"));
  EXPECT_THAT(at({}), ElementsAre("topic", "param", "load", "launch", "about", "inspect"));
}

TEST_F(Completion, tells_what_a_command_does) {
  const auto none = [](const NameQuestion&) { return std::vector<std::string>{}; };
  const auto all = completions(root, {"topic", "e"}, none, [] { return std::vector<std::string>{}; });
  EXPECT_THAT(all, ElementsAre(Candidate{"echo", "show messages"}));
}

TEST_F(Completion, offers_the_options_behind_a_dash) {
  EXPECT_THAT(at({"topic", "echo", "--"}), ElementsAre("--container", "--field", "--json", "--help"));
  EXPECT_THAT(at({"topic", "echo", "/scan", "-f"}), ElementsAre("-f"));
  EXPECT_THAT(at({"--v"}), ElementsAre("--version"));
}

TEST_F(Completion, asks_for_names_where_the_command_names_something) {
  EXPECT_THAT(at({"topic", "echo", "/s"}), ElementsAre("/scan", "/scan_filtered"));
  EXPECT_THAT(at({"topic", "echo", "/scan", ""}), IsEmpty()) << "it takes one topic";
  EXPECT_THAT(at({"topic", "echo", "--json", "/o"}), ElementsAre("/odom")) << "a flag takes no value";
  EXPECT_THAT(at({"topic", "echo", "--container", "robot", "/o"}), ElementsAre("/odom"));
  EXPECT_EQ(asked.container, "robot");
  EXPECT_THAT(at({"topic", "echo", "--container=arm", "/o"}), ElementsAre("/odom"));
  EXPECT_EQ(asked.container, "arm");
}

TEST_F(Completion, a_parameter_is_asked_of_the_node_before_it) {
  EXPECT_THAT(at({"param", "set", "/lidar", "r"}), ElementsAre("rate"));
  EXPECT_THAT(asked.positional, ElementsAre("/lidar"));
}

TEST_F(Completion, a_flag_may_change_what_a_word_names) {
  EXPECT_THAT(at({"about", ""}), ElementsAre("/lidar", "/camera"));
  EXPECT_THAT(at({"about", "--doc", "nacelle::i"}), ElementsAre("nacelle::imu::Imu"));
}

TEST_F(Completion, a_list_goes_on_taking_names) {
  EXPECT_THAT(at({"load", "a", "b", "nacelle::i"}), ElementsAre("nacelle::imu::Imu"));
}

TEST_F(Completion, offers_the_values_of_an_option) {
  EXPECT_THAT(at({"topic", "echo", "--container", ""}), ElementsAre("robot", "arm"));
  EXPECT_THAT(at({"param", "set", "--as", "t"}), ElementsAre("text"));
  EXPECT_THAT(at({"param", "set", "--as=t"}), ElementsAre("--as=text"));
  EXPECT_THAT(at({"param", "set", "--as", "="}), ElementsAre("int", "text")) << "bash takes --as= for two words";
  EXPECT_THAT(at({"param", "set", "--as", "=", "i"}), ElementsAre("int"));
}

TEST_F(Completion, leaves_files_to_the_shell_and_offers_nothing_for_unknown_words) {
  EXPECT_THAT(at({"launch", ""}), IsEmpty());
  EXPECT_THAT(at({"nonsense", "--no-such=x", ""}), IsEmpty());
  EXPECT_THAT(at({"topic", "echo", "--no-such="}), IsEmpty());
}

TEST_F(Completion, of_a_command_that_runs_and_has_others_below_it_offers_both) {
  EXPECT_THAT(at({"inspect", ""}), ElementsAre("net", "net_card", "disk"));
  EXPECT_THAT(at({"inspect", "ne"}), ElementsAre("net", "net_card"));
  EXPECT_THAT(at({"inspect", "disk", ""}), IsEmpty());
  EXPECT_THAT(at({"inspect", "--"}), ElementsAre("--all", "--help"));
}

}  // namespace
}  // namespace nacelle::cli
