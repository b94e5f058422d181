// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/graph_snapshot.hpp"

#include <gtest/gtest.h>

#include "nacelle/msgs/message_type.hpp"
#include "recordings.hpp"
#include "transport_dds/wire/names.hpp"

namespace nacelle::transport_dds {
namespace {

const Gid kOurs = recorded::gid("0110fa5e8be4654810e75956000001c1");
const Gid kWriter = recorded::gid("0110fa5e8be4654810e7595600000603");
const Gid kReader = recorded::gid("0110fa5e8be4654810e7595600000704");

TEST(GraphSnapshot, of_every_sample_that_ros_2_sent_is_written_back_as_it_was) {
  std::size_t seen = 0;
  for (const std::string recording : {"lc", "act"}) {
    for (const auto& sample : recorded::samples(recording)) {
      if (sample.topic != kDiscoveryTopic) continue;
      Snapshot snapshot;
      ASSERT_TRUE(msgs::from_cdr(sample.payload, snapshot));
      EXPECT_EQ(from_message(snapshot.gid), sample.writer.participant());
      EXPECT_EQ(dds_type_name(Snapshot::message_type().name).value(), sample.type);
      EXPECT_TRUE(recorded::is_padded(sample.payload, msgs::to_cdr(snapshot))) << to_hex(sample.payload);
      ++seen;
    }
  }
  EXPECT_EQ(seen, 105U);
}

// Tells a GraphSnapshot the way from one recorded sample to the next and compares.
TEST(GraphSnapshot, grows_as_that_of_the_recorded_talker_did) {
  std::size_t changes = 0;
  std::map<Gid, GraphSnapshot> ours;
  for (const auto& sample : recorded::samples("lc")) {
    if (sample.topic != kDiscoveryTopic) continue;
    Snapshot theirs;
    ASSERT_TRUE(msgs::from_cdr(sample.payload, theirs));
    GraphSnapshot& us = ours.try_emplace(from_message(theirs.gid), from_message(theirs.gid)).first->second;
    for (std::size_t i = 0; i < theirs.node_entities_info_seq.size(); ++i) {
      const auto& node = theirs.node_entities_info_seq[i];
      if (i == us.message().node_entities_info_seq.size()) us.add_node(node.node_namespace, node.node_name);
      const auto tell = [&](const auto& gids, bool is_writer) {
        const auto& known = us.message().node_entities_info_seq[i];
        const auto& have = is_writer ? known.writer_gid_seq : known.reader_gid_seq;
        for (std::size_t at = have.size(); at < gids.size(); ++at) {
          EXPECT_TRUE(us.add_endpoint(node.node_namespace, node.node_name, from_message(gids[at]), is_writer));
          ++changes;
        }
      };
      tell(node.reader_gid_seq, false);
      tell(node.writer_gid_seq, true);
    }
    while (us.message().node_entities_info_seq.size() > theirs.node_entities_info_seq.size()) {
      const auto& last = us.message().node_entities_info_seq.back();
      EXPECT_TRUE(us.remove_node(last.node_namespace, last.node_name));
    }
    const auto remove_all_but = [&](bool is_writer) {
      for (std::size_t i = 0; i < theirs.node_entities_info_seq.size(); ++i) {
        const auto& node = theirs.node_entities_info_seq[i];
        const auto known = us.message().node_entities_info_seq[i];
        for (const auto& gid : is_writer ? known.writer_gid_seq : known.reader_gid_seq) {
          const auto& wanted = is_writer ? node.writer_gid_seq : node.reader_gid_seq;
          if (std::find(wanted.begin(), wanted.end(), gid) != wanted.end()) continue;
          EXPECT_TRUE(us.remove_endpoint(from_message(gid), is_writer));
          ++changes;
        }
      }
    };
    remove_all_but(false);
    remove_all_but(true);
    EXPECT_EQ(us.message(), theirs);
  }
  EXPECT_GT(changes, 50U);
}

TEST(GraphSnapshot, has_the_bytes_of_the_facts) {
  GraphSnapshot us{kOurs};
  us.add_node("/", "talker");
  EXPECT_TRUE(us.add_endpoint("/", "talker", kWriter, true));

  EXPECT_EQ(to_hex(msgs::to_cdr(us.message())), "00010000" + kOurs.text() +
                                                    "01000000"
                                                    "02000000"
                                                    "2f000000"
                                                    "07000000"
                                                    "74616c6b65720000"
                                                    "00000000"
                                                    "01000000" +
                                                    kWriter.text());
}

TEST(GraphSnapshot, forgets_what_is_taken_away_and_nothing_else) {
  GraphSnapshot us{kOurs};
  us.add_node("/", "a");
  us.add_node("/", "b");
  EXPECT_TRUE(us.add_endpoint("/", "a", kReader, false));
  EXPECT_TRUE(us.add_endpoint("/", "b", kWriter, true));

  EXPECT_FALSE(us.remove_endpoint(kReader, true)) << "it is a reader";
  EXPECT_TRUE(us.remove_endpoint(kReader, false));
  EXPECT_FALSE(us.remove_endpoint(kReader, false));
  EXPECT_TRUE(us.remove_node("/", "a"));
  EXPECT_FALSE(us.remove_node("/", "a"));
  EXPECT_FALSE(us.remove_node("/ns", "b"));
  EXPECT_FALSE(us.add_endpoint("/", "a", kReader, false));
  ASSERT_EQ(us.message().node_entities_info_seq.size(), 1U);
  EXPECT_EQ(us.message().node_entities_info_seq[0].node_name, "b");
  EXPECT_EQ(us.message().node_entities_info_seq[0].writer_gid_seq.size(), 1U);
}

}  // namespace
}  // namespace nacelle::transport_dds
