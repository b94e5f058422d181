// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
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
  int changes = 0;

  /// One message that needs `way`; it comes `later` than the last.
  void send(Duration later, Duration way) {
    now.since_origin += later;
    wall.since_origin += later;
    const WallTime source{wall.since_origin - way + ahead};
    changes += clock.note(source, wall, now) ? 1 : 0;
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
}

TEST(PeerClock, finds_a_clock_that_is_ahead_once_and_as_it_is) {
  Peer peer;
  peer.ahead = 150ms;
  peer.send_for(60s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), 148ms);
  EXPECT_EQ(peer.changes, 1);
}

TEST(PeerClock, finds_a_clock_that_is_behind) {
  Peer peer;
  peer.ahead = -150ms;
  peer.send_for(60s, 100ms, [] { return 2ms; });
  EXPECT_EQ(peer.clock.ahead(), -152ms);
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

// Whatever the way does, as long as something comes within 80 ms every two seconds: what is told as ahead is true to the
// last nanosecond, less than 20 ms is never told, and a clock far off always is.
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
      if (told < 0ns) ASSERT_LT(peer.ahead, -PeerClock::kLeastAhead / 2);
    }
    if (peer.ahead > 20ms + least_way + 20ms) EXPECT_GT(peer.clock.ahead(), 0ns);
    if (peer.ahead < -180ms) EXPECT_LT(peer.clock.ahead(), 0ns);
  }
}

}  // namespace
}  // namespace nacelle::transport_dds
