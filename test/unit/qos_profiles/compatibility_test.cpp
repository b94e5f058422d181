// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/compatibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "nacelle/qos/presets.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle {
namespace {

using testing::HasSubstr;

// The oracle is rmw's table written down value by value, not a second implementation of the rule.
// Rows are offered, columns requested, both in the order of rmw's numbers; '.' ok, 'w' warning, 'E' error.
// Source: rmw_dds_common/src/qos.cpp (jazzy), qos_profile_check_compatible; best_available follows the other side.
using Table = std::array<std::string_view, 5>;
//                            requested:  def strong weak unk best     (weak and strong in rmw's order of each policy)
constexpr Table kReliability{/*default */ "ww.w.",
                             /*reliable*/ ".....",
                             /*best_eff*/ "wE.w.",
                             /*unknown */ "ww.w.",
                             /*best_av */ "....."};
constexpr Table kDurability{/*default */ "ww.w.",
                            /*tr_local*/ ".....",
                            /*volatile*/ "wE.w.",
                            /*unknown */ "ww.w.",
                            /*best_av */ "....."};
constexpr Table kLiveliness{/*default */ "w.ww.",
                            /*automat.*/ "w.Ew.",
                            /*manual  */ ".....",
                            /*unknown */ "w.ww.",
                            /*best_av */ "....."};
constexpr std::array kReliabilities{Reliability::SystemDefault, Reliability::Reliable, Reliability::BestEffort,
                                    Reliability::Unknown, Reliability::BestAvailable};
constexpr std::array kDurabilities{Durability::SystemDefault, Durability::TransientLocal, Durability::Volatile,
                                   Durability::Unknown, Durability::BestAvailable};
constexpr std::array kLivelinesses{Liveliness::SystemDefault, Liveliness::Automatic, Liveliness::ManualByTopic,
                                   Liveliness::Unknown, Liveliness::BestAvailable};

//                            requested:  infinite 10ms 20ms best
const std::array<Duration, 4> kDurations{Duration::zero(), 10ms, 20ms, kBestAvailableDuration};
constexpr std::array<std::string_view, 4> kDurationTable{/*infinite*/ ".EE.",
                                                         /*10ms    */ "....",
                                                         /*20ms    */ ".E..",
                                                         /*best    */ "...."};

int rank(char c) { return c == 'E' ? 2 : c == 'w' ? 1 : 0; }

struct Case {
  std::size_t reliability, durability, liveliness, deadline, lease;
};

QoS qos_of(const Case& c) {
  return QoS(10)
      .reliability(kReliabilities[c.reliability])
      .durability(kDurabilities[c.durability])
      .liveliness(kLivelinesses[c.liveliness])
      .deadline(kDurations[c.deadline])
      .liveliness_lease_duration(kDurations[c.lease]);
}

std::array<int, 5> expected(const Case& o, const Case& r) {
  return {rank(kReliability[o.reliability][r.reliability]), rank(kDurability[o.durability][r.durability]),
          rank(kDurationTable[o.deadline][r.deadline]), rank(kLiveliness[o.liveliness][r.liveliness]),
          rank(kDurationTable[o.lease][r.lease])};
}

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (std::size_t a = 0; a < 5; ++a) {
    for (std::size_t b = 0; b < 5; ++b) {
      for (std::size_t c = 0; c < 5; ++c) {
        for (std::size_t d = 0; d < 4; ++d) {
          for (std::size_t e = 0; e < 4; ++e) all.push_back({a, b, c, d, e});
        }
      }
    }
  }
  return all;
}

TEST(Compatibility, gives_rmws_verdict_for_every_pair_of_values) {
  const auto cases = all_cases();
  std::vector<QoS> values;
  values.reserve(cases.size());
  for (const auto& c : cases) values.push_back(qos_of(c));
  std::size_t wrong = 0;
  for (std::size_t o = 0; o < cases.size(); ++o) {
    for (std::size_t r = 0; r < cases.size(); ++r) {
      const auto e = expected(cases[o], cases[r]);
      const int worst = *std::max_element(e.begin(), e.end());
      if (static_cast<int>(verdict_of(values[o], values[r])) == worst) continue;
      if (++wrong <= 5)
        ADD_FAILURE() << "offered " << to_text(values[o]) << " | requested " << to_text(values[r]) << " expected "
                      << worst;
    }
  }
  EXPECT_EQ(wrong, 0U) << "of " << cases.size() * cases.size();
}

TEST(Compatibility, names_exactly_the_policies_that_clash) {
  const std::array<const char*, 5> policies{"reliability", "durability", "deadline", "liveliness",
                                            "liveliness_lease_duration"};
  const auto cases = all_cases();
  std::size_t clashes = 0;
  // Steps that share no factor with the number of cases visit pairs from the whole matrix.
  for (std::size_t i = 0; i < 40000; ++i) {
    const Case& o = cases[(i * 7919) % cases.size()];
    const Case& r = cases[(i * 104729 + i / cases.size()) % cases.size()];
    const auto e = expected(o, r);
    const int worst = *std::max_element(e.begin(), e.end());
    std::vector<std::string> named;
    for (std::size_t p = 0; p < 5; ++p) {
      if (worst > 0 && e[p] == worst) named.emplace_back(policies[p]);
    }
    const auto answer = check(qos_of(o), qos_of(r));
    std::vector<std::string> got;
    for (const auto& clash : answer.clashes) {
      got.push_back(clash.policy);
      EXPECT_EQ(static_cast<int>(clash.severity), worst);
      EXPECT_FALSE(clash.change.empty());
    }
    ASSERT_EQ(got, named) << to_text(qos_of(o)) << " | " << to_text(qos_of(r));
    ASSERT_EQ(answer.verdict, verdict_of(qos_of(o), qos_of(r)));
    clashes += got.size();
  }
  EXPECT_GT(clashes, 10000U);
}

TEST(Compatibility, does_not_depend_on_history_depth_or_lifespan) {
  for (const History history : {History::SystemDefault, History::KeepLast, History::KeepAll, History::Unknown}) {
    const QoS one = QoS(1).liveliness(Liveliness::Automatic);
    EXPECT_EQ(check(QoS(one).history(history), QoS(one).keep_all()).verdict, Verdict::Ok);
    EXPECT_EQ(check(QoS(one).lifespan(1ms), QoS(one).keep_last(7).history(history).lifespan(3s)).verdict, Verdict::Ok);
  }
}

TEST(Compatibility, tells_both_values_and_the_change_that_mends_it) {
  const auto answer = check(SensorDataQoS(), QoS(10));
  ASSERT_EQ(answer.clashes.size(), 1U);
  EXPECT_EQ(answer.clashes[0],
            (Clash{Verdict::Error, "reliability", "best_effort", "reliable",
                   "request reliability best_effort in the subscription, or offer reliable in the publisher"}));
  EXPECT_FALSE(answer);
  EXPECT_THAT(answer.text(),
              HasSubstr("error: reliability: the publisher offers best_effort, the subscription requests reliable"));
}

TEST(Compatibility, the_change_it_proposes_for_an_error_really_mends_it) {
  const auto cases = all_cases();
  for (std::size_t i = 0; i < 20000; ++i) {
    QoS offered = qos_of(cases[(i * 7919) % cases.size()]);
    const QoS requested = qos_of(cases[(i * 104729 + 13) % cases.size()]);
    const auto answer = check(offered, requested);
    if (answer.verdict != Verdict::Error) continue;
    for (const auto& clash : answer.clashes) {
      if (clash.policy == "reliability") offered.reliability(parse_reliability("reliable").value());
      if (clash.policy == "durability") offered.durability(parse_durability("transient_local").value());
      if (clash.policy == "liveliness") offered.liveliness(parse_liveliness("manual_by_topic").value());
      if (clash.policy == "deadline") offered.deadline(requested.deadline());
      if (clash.policy == "liveliness_lease_duration")
        offered.liveliness_lease_duration(requested.liveliness_lease_duration());
    }
    EXPECT_NE(check(offered, requested).verdict, Verdict::Error);
  }
}

TEST(Compatibility, of_resolved_values_is_never_a_warning) {
  for (const auto& c : all_cases()) {
    if (c.reliability == 3 || c.durability == 3 || c.liveliness == 3) continue;  // unknown stays unknown
    const QoS q = qos_of(c).resolved();
    EXPECT_NE(check(q, SystemDefaultsQoS().resolved()).verdict, Verdict::Warning) << to_text(q);
  }
}

TEST(Compatibility, explains_a_deadline_with_both_figures) {
  const auto none = check(QoS(1), QoS(1).deadline(100ms));
  EXPECT_EQ(none.clashes.at(0).offered, "infinite");
  EXPECT_EQ(none.clashes.at(0).change,
            "request no deadline in the subscription, or offer at most 100ms in the publisher");
  const auto slower = check(QoS(1).deadline(200ms), QoS(1).deadline(100ms));
  EXPECT_EQ(slower.clashes.at(0).change,
            "request a deadline of at least 200ms in the subscription, or offer at most 100ms in the publisher");
}

TEST(BestAvailable, of_a_subscription_is_the_strongest_that_every_publisher_serves) {
  const std::vector<QoS> mixed{QoS(1).transient_local(), QoS(1).best_effort()};
  const QoS q = best_available_for_subscription(BestAvailableQoS(), mixed);
  EXPECT_EQ(q.reliability(), Reliability::BestEffort);
  EXPECT_EQ(q.durability(), Durability::Volatile);
  EXPECT_EQ(q.liveliness(), Liveliness::Automatic);
  for (const QoS& publisher : mixed) EXPECT_NE(check(publisher, q).verdict, Verdict::Error);

  const QoS alone = best_available_for_subscription(BestAvailableQoS(), {});
  EXPECT_EQ(alone.reliability(), Reliability::Reliable);
  EXPECT_EQ(alone.durability(), Durability::TransientLocal);
  EXPECT_EQ(alone.deadline(), Duration::zero());
}

TEST(BestAvailable, takes_the_largest_deadline_to_read_and_the_smallest_to_write) {
  const std::vector<QoS> others{QoS(1).deadline(10ms), QoS(1).deadline(30ms)};
  EXPECT_EQ(best_available_for_subscription(BestAvailableQoS(), others).deadline(), Duration{30ms});
  EXPECT_EQ(best_available_for_publisher(BestAvailableQoS(), others).deadline(), Duration{10ms});
  EXPECT_EQ(best_available_for_publisher(BestAvailableQoS(), others).durability(), Durability::TransientLocal);
}

}  // namespace
}  // namespace nacelle
