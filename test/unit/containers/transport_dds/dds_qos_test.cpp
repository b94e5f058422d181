// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/dds_qos.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "nacelle/qos/compatibility.hpp"
#include "nacelle/qos/presets.hpp"
#include "recordings.hpp"

namespace nacelle::transport_dds {
namespace {

TEST(DdsQos, of_the_default_is_reliable_with_infinite_blocking) {
  const DdsQos dds = to_dds(QoS(10));

  EXPECT_EQ(dds.reliability, DdsReliability::Reliable);
  EXPECT_EQ(dds.max_blocking, kDdsInfinite);
  EXPECT_EQ(dds.durability, DdsDurability::Volatile);
  EXPECT_FALSE(dds.has_durability_service());
  EXPECT_EQ(dds.history, DdsHistory::KeepLast);
  EXPECT_EQ(dds.depth, 10);
  EXPECT_EQ(dds.deadline, kDdsInfinite);
  EXPECT_EQ(dds.lifespan, kDdsInfinite);
  EXPECT_EQ(dds.liveliness, DdsLiveliness::Automatic);
  EXPECT_EQ(dds.lease, kDdsInfinite);
  EXPECT_FALSE(dds.autodispose_unregistered_instances);
}

TEST(DdsQos, of_best_effort_blocks_never) {
  const DdsQos dds = to_dds(SensorDataQoS());

  EXPECT_EQ(dds.reliability, DdsReliability::BestEffort);
  EXPECT_EQ(dds.max_blocking, Duration::zero());
  EXPECT_EQ(dds.depth, 5);
}

TEST(DdsQos, of_rosout_keeps_a_thousand_for_ten_seconds) {
  const DdsQos dds = to_dds(RosoutQoS());

  EXPECT_EQ(dds.durability, DdsDurability::TransientLocal);
  EXPECT_TRUE(dds.has_durability_service());
  EXPECT_EQ(dds.depth, 1000);
  EXPECT_EQ(dds.lifespan, 10s);
}

TEST(DdsQos, of_keep_all_has_no_depth) {
  EXPECT_EQ(to_dds(QoS(KeepAll{})).history, DdsHistory::KeepAll);
  EXPECT_EQ(to_dds(QoS(KeepAll{})).depth, kDdsUnlimited);
}

TEST(DdsQos, is_concrete_where_the_program_left_it_open) {
  EXPECT_EQ(to_dds(SystemDefaultsQoS()), to_dds(QoS(1)));
  EXPECT_EQ(to_dds(BestAvailableQoS()).deadline, kDdsInfinite);
  EXPECT_EQ(to_dds(BestAvailableQoS()).lease, kDdsInfinite);
  EXPECT_EQ(to_dds(QoS(0)).depth, 1);
  EXPECT_EQ(to_dds(QoS(std::numeric_limits<std::size_t>::max())).depth, std::numeric_limits<std::int32_t>::max());
}

TEST(DdsQos, comes_back_as_it_went) {
  const QoS all[] = {
      QoS(10),
      SensorDataQoS(),
      RosoutQoS(),
      ClockQoS(),
      StaticTransformQoS(),
      QoS(KeepAll{}),
      QoS(7).deadline(100ms).lifespan(2s).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(1s)};
  for (const QoS& qos : all) {
    const QoS back = from_dds(to_dds(qos));
    EXPECT_EQ(back, qos.resolved()) << qos.depth();
    EXPECT_EQ(to_dds(back), to_dds(qos)) << qos.depth();
  }
}

TEST(DdsQos, of_a_peer_that_ros_cannot_say_is_unknown) {
  DdsQos dds;
  dds.durability = DdsDurability::Persistent;
  dds.liveliness = DdsLiveliness::ManualByParticipant;

  EXPECT_EQ(from_dds(dds).durability(), Durability::Unknown);
  EXPECT_EQ(from_dds(dds).liveliness(), Liveliness::Unknown);
}

TEST(DdsQos, of_a_peer_that_announces_nonsense_is_still_a_quality) {
  DdsQos dds;
  dds.depth = -7;
  dds.deadline = Duration::min();
  dds.lifespan = Duration::zero();
  dds.lease = kBestAvailableDuration;
  const QoS qos = from_dds(dds);

  EXPECT_EQ(qos.depth(), 1U);
  EXPECT_EQ(qos.deadline(), 1ns);
  EXPECT_EQ(qos.lifespan(), 1ns);
  EXPECT_EQ(qos.liveliness_lease_duration(), Duration::zero());
}

TEST(DdsQos, of_ros_discovery_info_is_as_rmw_has_it) {
  EXPECT_EQ(discovery_writer_qos().durability, DdsDurability::TransientLocal);
  EXPECT_EQ(discovery_writer_qos().depth, 1);
  EXPECT_EQ(discovery_reader_qos().history, DdsHistory::KeepAll);
  EXPECT_EQ(discovery_reader_qos().durability, DdsDurability::TransientLocal);
  EXPECT_TRUE(discovery_reader_qos().ignores_own_participant);
}

TEST(DdsQos, of_what_ros_2_announced_comes_back_as_it_went) {
  std::size_t seen = 0;
  for (const std::string recording : {"lifecycle", "action"}) {
    for (const auto& endpoint : recorded::endpoints(recording)) {
      if (endpoint.topic.starts_with("DCPS")) continue;  // Cyclone's own
      EXPECT_EQ(to_dds(from_dds(endpoint.qos)), endpoint.qos) << endpoint.topic;
      ++seen;
    }
  }
  EXPECT_GT(seen, 50U);
}

TEST(DdsQos, of_the_standard_topics_is_what_ros_2_announced) {
  const auto all = recorded::endpoints("lifecycle");
  const auto announced = [&](const char* topic, bool is_writer) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& endpoint) {
      return endpoint.topic == topic && endpoint.is_writer == is_writer;
    });
    return found == all.end() ? DdsQos{.depth = 0} : found->qos;
  };
  EXPECT_EQ(announced("rt/rosout", true), to_dds(RosoutQoS()));
  EXPECT_EQ(announced("rt/parameter_events", true), to_dds(ParameterEventsQoS()));
  EXPECT_EQ(announced("rt/parameter_events", false), to_dds(ParameterEventsQoS()));
  EXPECT_EQ(announced("rq/lc_talker/set_parametersRequest", false), to_dds(ParametersQoS()));
  EXPECT_EQ(announced("rr/lc_talker/get_stateReply", true), to_dds(ServicesQoS()));
  EXPECT_EQ(announced("ros_discovery_info", true), discovery_writer_qos());
  DdsQos reader = discovery_reader_qos();
  reader.ignores_own_participant = false;  // not on the wire
  EXPECT_EQ(announced("ros_discovery_info", false), reader);
}

TEST(DdsPolicy, names_what_keeps_a_pair_apart) {
  const auto apart = [](const QoS& offered, const QoS& requested) {
    return incompatible_policy(to_dds(offered), to_dds(requested));
  };
  EXPECT_EQ(apart(QoS(1), QoS(1)), DdsPolicy::Invalid);
  EXPECT_EQ(apart(QoS(1).best_effort(), QoS(1)), DdsPolicy::Reliability);
  EXPECT_EQ(apart(QoS(1), QoS(1).transient_local()), DdsPolicy::Durability);
  EXPECT_EQ(apart(QoS(1), QoS(1).deadline(1s)), DdsPolicy::Deadline);
  EXPECT_EQ(apart(QoS(1).deadline(2s), QoS(1).deadline(1s)), DdsPolicy::Deadline);
  EXPECT_EQ(apart(QoS(1), QoS(1).liveliness(Liveliness::ManualByTopic)), DdsPolicy::Liveliness);
  EXPECT_EQ(apart(QoS(1), QoS(1).liveliness_lease_duration(1s)), DdsPolicy::Liveliness);
}

TEST(DdsPolicy, has_the_names_of_ros_and_the_numbers_of_dds) {
  EXPECT_EQ(policy_name(static_cast<DdsPolicy>(2)), "durability");
  EXPECT_EQ(policy_name(static_cast<DdsPolicy>(4)), "deadline");
  EXPECT_EQ(policy_name(static_cast<DdsPolicy>(8)), "liveliness");
  EXPECT_EQ(policy_name(static_cast<DdsPolicy>(11)), "reliability");
  EXPECT_EQ(policy_name(static_cast<DdsPolicy>(4711)), "unknown policy");
}

QoS any_qos(std::mt19937& random) {
  const auto pick = [&](unsigned n) { return random() % n; };
  QoS qos(1 + pick(3));
  if (pick(2) == 0) qos.best_effort();
  if (pick(2) == 0) qos.transient_local();
  qos.liveliness(pick(2) == 0 ? Liveliness::Automatic : Liveliness::ManualByTopic);
  qos.deadline(pick(3) * 1s).liveliness_lease_duration(pick(3) * 1s).lifespan(pick(2) * 1s);
  return qos;
}

TEST(DdsPolicy, agrees_with_ros_2_on_every_pair) {
  const unsigned seed = 20261122;
  std::mt19937 random{seed};
  for (int i = 0; i < 5000; ++i) {
    const QoS offered = any_qos(random), requested = any_qos(random);
    const bool matches = incompatible_policy(to_dds(offered), to_dds(requested)) == DdsPolicy::Invalid;
    ASSERT_EQ(matches, verdict_of(offered, requested) == Verdict::Ok) << "seed " << seed << ", pair " << i;
  }
}

}  // namespace
}  // namespace nacelle::transport_dds
