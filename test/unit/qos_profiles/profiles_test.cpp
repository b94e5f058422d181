// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/profiles.hpp"

#include <gtest/gtest.h>

#include "nacelle/qos/presets.hpp"
#include "nacelle/qos/text.hpp"
#include "support/places.hpp"

namespace nacelle {
namespace {

std::string errors_of(const std::string& text) {
  const auto set = parse_profiles(text, "p.yaml");
  if (set) return "no error";
  std::string all;
  for (const auto& problem : set.error()) all += problem.text() + "\n";
  return all;
}

TEST(RobotProfiles, give_each_stream_what_the_robot_needs) {
  const auto set = load_profiles(test::source("qos_profiles/profiles/robot.yaml"));
  ASSERT_TRUE(set) << set.error().front().text();
  for (const char* name : {"camera", "scan"}) {
    const QoS q = set->find(name).value();
    EXPECT_EQ(q.reliability(), Reliability::BestEffort) << name;
    EXPECT_EQ(q.durability(), Durability::Volatile) << name;
    EXPECT_EQ(q.history(), History::KeepLast) << name;
    EXPECT_GE(q.depth(), 1U) << name;
    EXPECT_LE(q.depth(), 5U) << name;
  }
  EXPECT_EQ(to_text(set->find("cmd_vel").value()), "keep_last 10, reliable, volatile");
  EXPECT_EQ(to_text(set->find("robot_description").value()), "keep_last 1, reliable, transient_local");
  EXPECT_EQ(to_text(set->find("tf_static").value()), "keep_last 1, reliable, transient_local");
  EXPECT_EQ(to_text(set->find("emergency_stop").value()), "keep_all, reliable, transient_local");
  EXPECT_EQ(set->find("tf").value(), DynamicTransformQoS());
  EXPECT_EQ(set->find("tf_static_listener").value(), StaticTransformListenerQoS());
}

TEST(Profiles, start_from_a_preset_or_from_an_earlier_profile) {
  const auto set = parse_profiles(
      "profiles:\n  a: {profile: sensor_data, depth: 2}\n  b: {profile: a, deadline: 100ms}\n", "p.yaml");
  ASSERT_TRUE(set);
  EXPECT_EQ(set->find("b").value(), QoS(2).best_effort().deadline(100ms));
  EXPECT_EQ(set->profiles()[1].where, "p.yaml:3");
  EXPECT_EQ(set->find("services_default").value(), ServicesQoS());
}

TEST(Profiles, report_file_line_and_nearest_name_of_every_mistake) {
  EXPECT_EQ(errors_of("profiles:\n  a:\n    relability: reliable\n    durability: volatil\n    depth: 0\n"),
            "p.yaml:3: unknown QoS key 'relability'; did you mean 'reliability'?\n"
            "p.yaml:4: 'volatil' is not a durability; did you mean 'volatile'?\n"
            "p.yaml:5: depth must be a whole number from 1 to 16777216\n");
  EXPECT_EQ(errors_of("profile: {}"), "p.yaml:1: unknown key 'profile'; did you mean 'profiles'?\n");
  EXPECT_EQ(errors_of("profiles: {a: {profile: sensor_dat}}"),
            "p.yaml:1: no QoS profile has the name 'sensor_dat'; did you mean 'sensor_data'?\n");
  EXPECT_EQ(errors_of("profiles:\n  a: {}\n  a: {}\n"), "p.yaml:3: the profile 'a' is already at p.yaml:2\n");
  EXPECT_EQ(errors_of("profiles: {a: {deadline: 0s}}"),
            "p.yaml:1: a deadline of 0 cannot be kept; write infinite, or leave it out\n");
  EXPECT_EQ(errors_of("[]"), "p.yaml:1: expected a map with the key 'profiles', found a list\n");
}

TEST(QosPatch, changes_only_what_it_gives) {
  QosPatch patch;
  EXPECT_EQ(patch.applied_to(RosoutQoS()), RosoutQoS());
  ASSERT_TRUE(set_policy(patch, "reliability", "best_effort"));
  EXPECT_EQ(patch.applied_to(RosoutQoS()), RosoutQoS().best_effort());
  ASSERT_TRUE(set_policy(patch, "lifespan", "infinite"));
  EXPECT_EQ(patch.applied_to(RosoutQoS()).lifespan(), Duration::zero());
  ASSERT_TRUE(set_policy(patch, "depth", "3"));
  EXPECT_EQ(patch.applied_to(QoS(KeepAll())).history(), History::KeepLast);
  ASSERT_TRUE(set_policy(patch, "history", "keep_all"));
  EXPECT_EQ(patch.applied_to(QoS(1)).history(), History::KeepAll);
}

TEST(QosPatch, says_what_a_dry_pool_does) {
  for (const auto& [word, policy] :
       {std::pair{"grow", PoolPolicy::Grow}, {"drop", PoolPolicy::Drop}, {"fail", PoolPolicy::Fail}}) {
    QosPatch patch;
    ASSERT_TRUE(set_policy(patch, "when_dry", word));
    EXPECT_EQ(patch.applied_to(QoS(1)).when_dry(), policy);
  }
  QosPatch patch;
  EXPECT_EQ(set_policy(patch, "when_dry", "dorp").error().text(),
            "'dorp' is not a policy for a dry pool; did you mean 'drop'?");
}

TEST(QosPatch, knows_each_of_its_keys) {
  for (const auto& key : qos_keys()) {
    QosPatch patch;
    const auto refused = set_policy(patch, key, "\x01nonsense");
    if (key != "profile") {
      ASSERT_FALSE(refused) << key;
      EXPECT_EQ(refused.error().what.find("unknown QoS key"), std::string::npos) << key;
      EXPECT_EQ(patch, QosPatch{}) << key;
    }
  }
}

}  // namespace
}  // namespace nacelle
