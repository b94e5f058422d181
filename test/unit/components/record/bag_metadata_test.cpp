// SPDX-License-Identifier: Apache-2.0
#include "record/model/bag_metadata.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

namespace nacelle::record {
namespace {

TEST(BagMetadata, writes_profiles_in_rosbag2s_words) {
  const auto all = YAML::Load(offered_qos_profiles({QoS(10), QoS(5).best_effort().transient_local().deadline(1500ms)}));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0]["history"].as<std::string>(), "keep_last");
  EXPECT_EQ(all[0]["depth"].as<int>(), 10);
  EXPECT_EQ(all[0]["reliability"].as<std::string>(), "reliable");
  EXPECT_EQ(all[0]["durability"].as<std::string>(), "volatile");
  EXPECT_EQ(all[0]["deadline"]["sec"].as<std::int64_t>(), 9223372036);
  EXPECT_EQ(all[0]["deadline"]["nsec"].as<std::int64_t>(), 854775807);
  EXPECT_EQ(all[0]["liveliness"].as<std::string>(), "automatic");
  EXPECT_FALSE(all[0]["avoid_ros_namespace_conventions"].as<bool>());
  EXPECT_EQ(all[1]["reliability"].as<std::string>(), "best_effort");
  EXPECT_EQ(all[1]["durability"].as<std::string>(), "transient_local");
  EXPECT_EQ(all[1]["deadline"]["sec"].as<std::int64_t>(), 1);
  EXPECT_EQ(all[1]["deadline"]["nsec"].as<std::int64_t>(), 500'000'000);
  EXPECT_EQ(YAML::Load(offered_qos_profiles({})).size(), 0U);
}

TEST(BagMetadata, reads_profiles_in_words_and_in_numbers) {
  const std::vector<QoS> offered{QoS(7), QoS(5).best_effort().transient_local(), QoS(KeepAll{})};
  const auto again = read_qos_profiles(offered_qos_profiles(offered));
  ASSERT_EQ(again.size(), 3U);
  EXPECT_EQ(again[0], QoS(7));
  EXPECT_EQ(again[1], QoS(5).best_effort().transient_local());
  EXPECT_TRUE(again[2].keeps_all());
  const auto numbers = read_qos_profiles("- history: 1\n  depth: 0\n  reliability: 2\n  durability: 1\n");
  ASSERT_EQ(numbers.size(), 1U);
  EXPECT_EQ(numbers[0], QoS(10).best_effort().transient_local());
  for (const char* wrong : {"", "[", "history: 1", "- a\n- b"}) {
    for (const QoS& qos : read_qos_profiles(wrong)) EXPECT_EQ(qos, QoS(10)) << wrong;
  }
}

TEST(BagMetadata, reads_deadlines_and_leases) {
  const QoS watched =
      QoS(7).deadline(1500ms).lifespan(2s).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(3s);
  const auto again = read_qos_profiles(offered_qos_profiles({watched, QoS(7)}));
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[0], watched);
  EXPECT_EQ(again[1], QoS(7)) << "rmw's infinite time is none";
  for (const char* sec : {"18446744073709551615", "9223372037", "-1", "x", "[1]"}) {
    const auto odd = read_qos_profiles(std::string{"- deadline:\n    sec: "} + sec + "\n    nsec: 0\n");
    ASSERT_EQ(odd.size(), 1U);
    EXPECT_EQ(odd[0].deadline(), Duration::zero()) << sec;
  }
  EXPECT_EQ(read_qos_profiles("- deadline: 3\n").at(0).deadline(), Duration::zero());
}

TEST(BagMetadata, the_strongest_qos_fits_the_readers_of_each_publisher) {
  EXPECT_EQ(strongest_qos({}), QoS(10));
  const QoS one = QoS(5).best_effort().deadline(2s).lifespan(1s).liveliness_lease_duration(1s);
  const QoS other = QoS(9).transient_local().deadline(1s).lifespan(3s).liveliness(Liveliness::ManualByTopic);
  const QoS both = QoS(9)
                       .transient_local()
                       .deadline(1s)
                       .lifespan(3s)
                       .liveliness(Liveliness::ManualByTopic)
                       .liveliness_lease_duration(1s);
  EXPECT_EQ(strongest_qos({one, other}), both);
  EXPECT_EQ(strongest_qos({other, one}), both);
  EXPECT_EQ(strongest_qos({one, QoS(1)}).lifespan(), Duration::zero());
}

TEST(BagMetadata, adds_the_files_up) {
  BagMetadata known;
  known.topics.push_back({"/scan", "sensor_msgs/msg/LaserScan", "RIHS01_00", {QoS(5)}, 7});
  known.files = {{"a \"b\"_0.mcap", 5, 1000, 3000}, {"empty", 0, 0, 0}, {"a_1.mcap", 2, 2500, 6000}};
  const auto bag = YAML::Load(metadata_yaml(known))["rosbag2_bagfile_information"];
  EXPECT_EQ(bag["version"].as<int>(), 9);
  EXPECT_EQ(bag["storage_identifier"].as<std::string>(), "mcap");
  EXPECT_EQ(bag["starting_time"]["nanoseconds_since_epoch"].as<int>(), 1000);
  EXPECT_EQ(bag["duration"]["nanoseconds"].as<int>(), 5000);
  EXPECT_EQ(bag["message_count"].as<int>(), 7);
  EXPECT_EQ(bag["relative_file_paths"][0].as<std::string>(), "a \"b\"_0.mcap");
  EXPECT_EQ(bag["files"][2]["path"].as<std::string>(), "a_1.mcap");
  EXPECT_EQ(bag["files"][2]["duration"]["nanoseconds"].as<int>(), 3500);
  const auto topic = bag["topics_with_message_count"][0];
  EXPECT_EQ(topic["topic_metadata"]["name"].as<std::string>(), "/scan");
  EXPECT_EQ(topic["topic_metadata"]["offered_qos_profiles"][0]["depth"].as<int>(), 5);
  EXPECT_EQ(topic["topic_metadata"]["type_description_hash"].as<std::string>(), "RIHS01_00");
  EXPECT_EQ(topic["message_count"].as<int>(), 7);
}

TEST(BagMetadata, is_valid_without_topics_and_files) {
  const auto bag = YAML::Load(metadata_yaml({}))["rosbag2_bagfile_information"];
  EXPECT_EQ(bag["message_count"].as<int>(), 0);
  EXPECT_EQ(bag["files"].size(), 0U);
  EXPECT_EQ(bag["topics_with_message_count"].size(), 0U);
}

}  // namespace
}  // namespace nacelle::record
