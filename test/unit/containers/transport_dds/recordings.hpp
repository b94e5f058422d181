// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/places.hpp"
#include "transport_dds/wire/discovered.hpp"

// What ROS 2 jazzy was heard to say (test/data/ros2_wire).
namespace nacelle::transport_dds::recorded {

inline std::vector<nlohmann::json> lines(const std::string& name) {
  std::ifstream file(test::data("ros2_wire/" + name + ".jsonl"));
  std::vector<nlohmann::json> all;
  for (std::string line; std::getline(file, line);) all.push_back(nlohmann::json::parse(line));
  EXPECT_FALSE(all.empty()) << name;
  return all;
}

inline Bytes bytes(const std::string& hex) {
  Bytes out;
  EXPECT_TRUE(from_hex(hex, out)) << hex;
  return out;
}

inline Gid gid(const std::string& hex) {
  const Bytes read = bytes(hex);
  Gid made;
  EXPECT_EQ(read.size(), Gid::kBytes) << hex;
  std::copy_n(read.begin(), std::min(read.size(), Gid::kBytes), made.bytes.begin());
  return made;
}

inline Duration duration(const nlohmann::json& qos, const std::string& key) {
  if (qos.contains(key + "_ns")) return Duration{qos.at(key + "_ns").get<std::int64_t>()};
  EXPECT_EQ(qos.value(key, "inf"), "inf");
  return kDdsInfinite;
}

inline DdsQos qos(const nlohmann::json& json) {
  DdsQos made;
  const bool reliable = json.at("reliability") == "RELIABLE";
  made.reliability = reliable ? DdsReliability::Reliable : DdsReliability::BestEffort;
  made.max_blocking = duration(json, "max_blocking");
  made.durability = json.at("durability") == "VOLATILE" ? DdsDurability::Volatile : DdsDurability::TransientLocal;
  made.history = json.at("history") == "KEEP_ALL" ? DdsHistory::KeepAll : DdsHistory::KeepLast;
  made.depth = json.at("depth").get<std::int32_t>();
  made.deadline = duration(json, "deadline");
  made.lifespan = duration(json, "lifespan");
  EXPECT_EQ(json.at("liveliness"), "AUTOMATIC");
  made.lease = duration(json, "lease");
  made.autodispose_unregistered_instances = json.value("autodispose_unregistered", false);
  return made;
}

/// The participants in the builtin topics of a recording ("lifecycle", "action"), the recorder's own included.
inline std::vector<DiscoveredParticipant> participants(const std::string& recording) {
  std::vector<DiscoveredParticipant> all;
  for (const auto& line : lines("ddsdump_" + recording)) {
    if (line.at("kind") != "participant") continue;
    all.push_back({gid(line.at("guid")), bytes(line.at("qos").at("user_data_hex")), {}, {}, {}});
  }
  return all;
}

/// The writers and readers in them.
inline std::vector<DiscoveredEndpoint> endpoints(const std::string& recording) {
  std::vector<DiscoveredEndpoint> all;
  for (const auto& line : lines("ddsdump_" + recording)) {
    if (line.at("kind") == "participant") continue;
    all.push_back({gid(line.at("guid")), gid(line.at("participant")), line.at("kind") == "publication",
                   line.at("topic"), line.at("type"), qos(line.at("qos")), bytes(line.at("qos").at("user_data_hex"))});
  }
  return all;
}

/// All announcements of writers and readers that were captured, without their QoS.
inline std::vector<DiscoveredEndpoint> announcements() {
  std::vector<DiscoveredEndpoint> all;
  for (const std::string name : {"discovery_lc", "discovery_act"}) {
    for (const auto& line : lines(name)) {
      if (line.at("kind") == "SPDP") continue;
      const auto& said = line.at("pids");
      const std::string user_data = said.value("USER_DATA", "");
      const Gid endpoint = gid(said.at("ENDPOINT_GUID"));
      all.push_back({endpoint,
                     endpoint.participant(),
                     line.at("kind") == "SEDP-pub",
                     said.at("TOPIC_NAME"),
                     said.at("TYPE_NAME"),
                     {},
                     Bytes(user_data.begin(), user_data.end())});
    }
  }
  return all;
}

struct Sample {
  std::string topic, type;
  Gid writer;
  Bytes payload;
};

/// The samples of a recording ("lc", "act"), in their order.
inline std::vector<Sample> samples(const std::string& recording) {
  std::vector<Sample> all;
  for (const auto& line : lines("user_" + recording)) {
    const Gid writer = gid(line.at("prefix").get<std::string>() + line.at("writer").get<std::string>());
    all.push_back({line.at("topic"), line.at("type"), writer, bytes(line.at("payload"))});
  }
  return all;
}

/// True if `sample` is `written` and at most three bytes of padding.
inline bool is_padded(const Bytes& sample, const Bytes& written) {
  return sample.size() >= written.size() && sample.size() < written.size() + 4 &&
         std::equal(written.begin(), written.end(), sample.begin()) &&
         std::all_of(sample.begin() + static_cast<std::ptrdiff_t>(written.size()), sample.end(),
                     [](std::uint8_t byte) { return byte == 0; });
}

}  // namespace nacelle::transport_dds::recorded
