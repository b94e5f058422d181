// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

#include "transport_dds/wire/peer_clock.hpp"

namespace nacelle::transport_dds {
namespace {

/// A peer whose messages come over a way; times are ours unless they are stamps.
class Peer {
 public:
  PeerClock clock;
  Duration ahead{};
  WallTime wall{1'790'000'000s};
  MonotonicTime now{100s};
  int changes = 0, questions = 0;
  /// Of a node that answers; without, there is none.
  struct Ways {
    Duration there, back;
  };
  std::function<Ways()> answers;

  /// One message that needs `way`; it comes `later` than the last. Questions are answered at once.
  void send(Duration later, Duration way) {
    now.since_origin += later;
    wall.since_origin += later;
    const WallTime source{wall.since_origin - way + ahead};
    changes += clock.note(source, wall, now) ? 1 : 0;
    if (!clock.is_worth_asking(now)) return;
    ++questions;
    clock.begin_asking();
    EXPECT_FALSE(clock.is_worth_asking(now));
    if (answers) answer(answers());
    clock.end_asking(now);
  }
  void answer(Ways ways) {
    const auto took = ways.there + ways.back;
    clock.note_answer({.asked = {wall.since_origin - took},
                       .asked_at = {now.since_origin - took},
                       .source = {wall.since_origin - ways.back + ahead},
                       .came = wall,
                       .came_at = now});
  }
  template <typename Way>
  void send_for(Duration time, Duration period, Way way) {
    for (Duration passed{}; passed < time; passed += period) send(period, way());
  }
};

TEST(PeerClock, says_nothing_of_a_clock_that_agrees) {
  Peer peer;
  EXPECT_EQ(peer.clock.least_age(), Duration::max());
  peer.send_for(60s, 100ms, [] { return 1ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  EXPECT_EQ(peer.changes, 0);
  EXPECT_EQ(peer.clock.least_age(), 1ms);
  EXPECT_EQ(peer.questions, 0);
}

TEST(PeerClock, finds_a_clock_that_is_ahead_once_and_as_it_is) {
  Peer peer;
  peer.ahead = 150ms;
  peer.send_for(60s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), 148ms);
  EXPECT_TRUE(peer.clock.is_certain());
  EXPECT_EQ(peer.changes, 1);
  EXPECT_EQ(peer.questions, 0);
}

TEST(PeerClock, finds_a_clock_that_is_behind) {
  Peer peer;
  peer.ahead = -150ms;
  peer.send_for(60s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), -152ms);
  EXPECT_FALSE(peer.clock.is_certain());
  EXPECT_EQ(peer.changes, 1);
}

TEST(PeerClock, does_not_take_a_slow_link_for_a_clock) {
  Peer peer;
  peer.ahead = 5ms;
  peer.send_for(120s, 50ms, [] { return 50ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  EXPECT_EQ(peer.changes, 0);
}

// A queue that fills and empties: its least delay of two seconds wanders.
TEST(PeerClock, does_not_take_a_queue_for_a_clock) {
  Peer peer;
  Duration queued = 120ms;
  peer.send_for(120s, 50ms, [&] {
    queued = queued > 800ms ? Duration{120ms} : queued + 1ms;
    return queued;
  });
  EXPECT_EQ(peer.changes, 0);
}

TEST(PeerClock, does_not_believe_one_stamp_from_the_future) {
  Peer peer;
  peer.send_for(10s, 100ms, [] { return 1ms; });
  peer.send(100ms, -10s);
  peer.send_for(40s, 100ms, [] { return 1ms; });
  EXPECT_EQ(peer.changes, 0);
  EXPECT_FALSE(peer.clock.note(WallTime{Duration::min()}, peer.wall, peer.now));
}

TEST(PeerClock, tells_when_the_clock_has_been_put_right) {
  Peer peer;
  peer.ahead = 3s;
  peer.send_for(20s, 100ms, [] { return 1ms; });
  EXPECT_GT(peer.clock.ahead(), 2900ms);
  peer.ahead = 0ms;
  peer.send_for(PeerClock::kSlices * PeerClock::kSlice + 3s, 100ms, [] { return 1ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  EXPECT_EQ(peer.changes, 2);
}

TEST(PeerClock, begins_anew_when_our_own_clock_is_set) {
  Peer peer;
  peer.send_for(20s, 100ms, [] { return 1ms; });
  peer.wall.since_origin += 1s;  // now ours is ahead, and the peer's behind
  peer.ahead = -1s;
  peer.send_for(20s, 100ms, [] { return 1ms; });
  EXPECT_EQ(peer.clock.ahead(), -1001ms);
  EXPECT_EQ(peer.changes, 1);
}

TEST(PeerClock, does_not_repeat_what_hardly_changes) {
  Peer peer;
  peer.ahead = 100ms;
  for (int second = 0; second < 600; ++second) {
    peer.ahead += 20us;  // a quartz
    peer.send_for(1s, 200ms, [] { return 1ms; });
  }
  EXPECT_EQ(peer.changes, 1);
}

// For any delays, as long as one message arrives within 80 ms every two seconds: a reported lead is true to the nanosecond, a
// lead below 20 ms is never reported, and a clock that is far off always is.
TEST(PeerClock, tells_only_what_is_so) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random{seed};
    std::uniform_int_distribution<int> any_ms{-400, 400};
    std::exponential_distribution<double> jitter_s{50.0};
    std::bernoulli_distribution lost{0.3};
    Peer peer;
    peer.ahead = Duration{std::chrono::milliseconds{any_ms(random)}};
    const Duration least_way = std::chrono::milliseconds{std::uniform_int_distribution<int>{0, 60}(random)};
    const double drift = std::uniform_real_distribution<double>{-100e-6, 100e-6}(random);
    const Duration period = std::chrono::milliseconds{std::uniform_int_distribution<int>{10, 300}(random)};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", ahead " << peer.ahead.count() << " ns, way "
                                      << least_way.count() << " ns, every " << period.count() << " ns");
    Duration most_ahead = peer.ahead;
    for (Duration passed{}; passed < 60s; passed += period) {
      peer.ahead += from_seconds(to_seconds(period) * drift);
      most_ahead = std::max(most_ahead, peer.ahead);
      // What was lost comes again, a heartbeat later.
      peer.send(period, least_way + from_seconds(std::min(jitter_s(random), 1.0)) + (lost(random) ? 100ms : 0ms));
      const Duration told = peer.clock.ahead();
      if (told > 0ns) {
        ASSERT_LE(told, most_ahead);
        ASSERT_GE(told, 10ms);
      }
      if (told < 0ns) { ASSERT_LT(peer.ahead, -PeerClock::kLeastAhead / 2); }
    }
    if (peer.ahead > 20ms + least_way + 20ms) { EXPECT_GT(peer.clock.ahead(), 0ns); }
    if (peer.ahead < -180ms) { EXPECT_LT(peer.clock.ahead(), 0ns); }
  }
}

// --- with a node that answers ----------------------------------------------------------------------------------------

constexpr Duration kDrift =
    200us;  // answers are evaluated when the slice ends; the clocks may have drifted this far by then

TEST(PeerClock, is_sure_of_a_clock_that_is_behind_once_it_has_been_asked) {
  Peer peer;
  peer.ahead = -40ms;
  peer.answers = [] { return Peer::Ways{2ms, 3ms}; };
  peer.send_for(58s, 100ms, [] { return 3ms; });
  EXPECT_EQ(peer.clock.ahead(), -38ms + kDrift);
  EXPECT_TRUE(peer.clock.is_certain());
  EXPECT_EQ(peer.changes, 1);
  EXPECT_EQ(peer.questions, 2);  // and thirty seconds later, since an answer does not hold for ever
}

TEST(PeerClock, does_not_take_a_slow_link_for_a_clock_that_can_be_asked) {
  Peer peer;
  peer.answers = [] { return Peer::Ways{150ms, 160ms}; };
  peer.send_for(300s, 50ms, [] { return 160ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  EXPECT_EQ(peer.changes, 0);
  EXPECT_GE(peer.questions, 9);
  EXPECT_LE(peer.questions, 11);
}

TEST(PeerClock, tells_no_guess_while_it_asks) {
  Peer peer;
  peer.ahead = -150ms;
  for (int i = 0; i < 600 && !peer.clock.is_worth_asking(peer.now); ++i) {
    peer.now.since_origin += 100ms;
    peer.wall.since_origin += 100ms;
    peer.clock.note({peer.wall.since_origin - 2ms + peer.ahead}, peer.wall, peer.now);
  }
  ASSERT_TRUE(peer.clock.is_worth_asking(peer.now));
  peer.clock.begin_asking();
  peer.send_for(20s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  peer.clock.end_asking(peer.now);
  peer.send_for(3s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), -152ms);
  EXPECT_FALSE(peer.clock.is_certain());
}

TEST(PeerClock, takes_a_guess_for_certain_when_a_node_that_answers_has_come) {
  Peer peer;
  peer.ahead = -150ms;
  peer.send_for(40s, 100ms, [] { return 2ms; });
  EXPECT_FALSE(peer.clock.is_certain());
  peer.answers = [] { return Peer::Ways{1ms, 2ms}; };
  peer.send_for(40s, 100ms, [] { return 2ms; });
  EXPECT_TRUE(peer.clock.is_certain());
  EXPECT_EQ(peer.clock.ahead(), -149ms + kDrift);
  EXPECT_EQ(peer.changes, 2);
}

TEST(PeerClock, believes_the_shortest_of_several_round_trips) {
  Peer peer;
  peer.ahead = -40ms;
  int asked = 0;
  peer.answers = [&] {
    peer.answer({500ms, 3ms});
    peer.answer({2ms, 100ms});
    return Peer::Ways{80ms, 3ms + ++asked * 1ms};
  };
  peer.send_for(20s, 100ms, [] { return 3ms; });
  EXPECT_EQ(peer.clock.ahead(), -38ms + kDrift);
  EXPECT_EQ(asked, 1);
}

TEST(PeerClock, tells_when_a_clock_that_was_behind_has_been_put_right) {
  Peer peer;
  peer.ahead = -40ms;
  peer.answers = [] { return Peer::Ways{2ms, 2ms}; };
  peer.send_for(20s, 100ms, [] { return 2ms; });
  ASSERT_TRUE(peer.clock.is_certain());
  peer.ahead = 0ms;
  peer.send_for(5s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  EXPECT_EQ(peer.changes, 2);
  const int before = peer.questions;
  peer.send_for(120s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.questions, before);
  EXPECT_EQ(peer.changes, 2);
}

TEST(PeerClock, finds_a_clock_that_goes_back_while_the_link_is_slow) {
  Peer peer;
  peer.answers = [] { return Peer::Ways{30ms, 30ms}; };
  peer.send_for(60s, 100ms, [] { return 30ms; });
  EXPECT_EQ(peer.changes, 0);
  peer.ahead = -100ms;
  peer.send_for(60s, 100ms, [] { return 30ms; });
  EXPECT_EQ(peer.clock.ahead(), -70ms + kDrift);
  EXPECT_TRUE(peer.clock.is_certain());
}

TEST(PeerClock, forgets_answers_when_our_own_clock_is_set) {
  Peer peer;
  peer.ahead = -40ms;
  peer.answers = [] { return Peer::Ways{2ms, 2ms}; };
  peer.send_for(20s, 100ms, [] { return 2ms; });
  ASSERT_EQ(peer.clock.ahead(), -38ms + kDrift);
  // An answer to an earlier question arrives after it.
  peer.wall.since_origin -= 40ms;
  peer.ahead = 0ms;
  peer.send(100ms, 2ms);
  peer.clock.note_answer({.asked = {peer.wall.since_origin + 40ms},
                          .asked_at = {peer.now.since_origin - 5ms},
                          .source = peer.wall,
                          .came = peer.wall,
                          .came_at = peer.now});
  peer.send_for(10s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), 0ns);
  EXPECT_EQ(peer.changes, 2);
}

TEST(PeerClock, does_not_believe_an_answer_without_a_stamp) {
  Peer peer;
  peer.send_for(10s, 100ms, [] { return 60ms; });
  peer.clock.note_answer({peer.wall, peer.now, WallTime{Duration::min()}, peer.wall, peer.now});
  peer.send_for(10s, 100ms, [] { return 60ms; });
  EXPECT_EQ(peer.changes, 0);
}

// For any delays in both directions: an offset reported as certain is true to the nanosecond, and a clock that is behind by more
// than the delay of the outward path is found.
TEST(PeerClock, reports_only_certain_offsets_of_peers_that_answer) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random{seed};
    std::uniform_int_distribution<int> any_ms{-200, 200}, way_ms{0, 100};
    std::exponential_distribution<double> jitter_s{50.0};
    Peer peer;
    peer.ahead = Duration{std::chrono::milliseconds{any_ms(random)}};
    const Duration there = std::chrono::milliseconds{way_ms(random)}, back = std::chrono::milliseconds{way_ms(random)};
    const double drift = std::uniform_real_distribution<double>{-100e-6, 100e-6}(random);
    const auto later = [&] { return from_seconds(std::min(jitter_s(random), 1.0)); };
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", ahead " << peer.ahead.count() << " ns, there "
                                      << there.count() << " ns, back " << back.count() << " ns");
    Duration shortest = 10s;
    peer.answers = [&] {
      for (int i = 0; i < 2; ++i) {
        const Peer::Ways ways{there + later(), back + later()};
        shortest = std::min(shortest, ways.there);
        peer.answer(ways);
      }
      const Peer::Ways ways{there + later(), back + later()};
      shortest = std::min(shortest, ways.there);
      return ways;
    };
    Duration least_ahead = peer.ahead;
    for (Duration passed{}; passed < 100s; passed += 100ms) {
      peer.ahead += from_seconds(0.1 * drift);
      least_ahead = std::min(least_ahead, peer.ahead);
      peer.send(100ms, back + later());
      if (peer.clock.ahead() >= 0ns) continue;
      ASSERT_TRUE(peer.clock.is_certain());
      ASSERT_GE(peer.clock.ahead(), least_ahead);
    }
    if (-peer.ahead > shortest + 30ms) { EXPECT_LT(peer.clock.ahead(), 0ns); }
  }
}

}  // namespace
}  // namespace nacelle::transport_dds
