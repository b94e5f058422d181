// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::spatial {
namespace {

WallTime at_ms(std::int64_t ms) { return WallTime{Duration{ms * 1'000'000}}; }

// Writers keep x == y == seconds and yaw == 0.1 * seconds (wrapped by the quaternion); a torn sample breaks one of them.
RigidTransform at_place(std::int64_t ms) {
  const double s = 1e-3 * static_cast<double>(ms);
  return RigidTransform::planar(s, s, 0.1 * s);
}

void expect_no_torn_sample(const TransformBufferOptions& options, std::int64_t steps) {
  TransformBuffer buffer{options};
  ASSERT_TRUE(buffer.insert("odom", "base", at_ms(1000), at_place(1000), Permanence::Dynamic));
  ASSERT_TRUE(buffer.insert("odom", "base", at_ms(1001), at_place(1001), Permanence::Dynamic));
  std::atomic<std::int64_t> newest{1001};
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> answered{0}, torn{0};
  constexpr int kReaders = 3;

  std::vector<std::thread> readers;
  for (int r = 0; r < kReaders; ++r) {
    readers.emplace_back([&, r] {
      std::int64_t back = r;
      while (!stop.load(std::memory_order_relaxed)) {
        back = (back + 1) % 7;
        const std::int64_t ms = newest.load(std::memory_order_acquire) - back;
        const auto found = back == 0 ? buffer.lookup_latest("odom", "base") : buffer.lookup("odom", "base", at_ms(ms));
        if (!found) continue;  // pruned meanwhile
        const double s = to_seconds(found->stamp.since_origin);
        const double yaw = yaw_from_quaternion(found->X_TS.rotation);
        const bool whole = std::abs(found->X_TS.translation_m.x() - s) < 1e-9 &&
                           std::abs(found->X_TS.translation_m.y() - s) < 1e-9 &&
                           std::abs(shortest_turn(yaw, 0.1 * s)) < 1e-9;
        (whole ? answered : torn).fetch_add(1, std::memory_order_relaxed);
      }
    });
  }
  for (std::int64_t i = 0; i < steps; ++i) {
    const std::int64_t ms = 1002 + i;
    // Every tenth sample comes late, so that sorting in is seen by readers too.
    if (i % 10 == 5) {
      static_cast<void>(buffer.insert("odom", "base", at_ms(ms + 1), at_place(ms + 1), Permanence::Dynamic));
    }
    static_cast<void>(buffer.insert("odom", "base", at_ms(ms), at_place(ms), Permanence::Dynamic));
    newest.store(ms, std::memory_order_release);
    if (i % 64 == 0) std::this_thread::yield();
  }
  stop = true;
  for (auto& reader : readers) reader.join();

  EXPECT_EQ(torn.load(), 0U);
  EXPECT_EQ(buffer.stats().inserted + buffer.stats().duplicates, static_cast<std::uint64_t>(steps + steps / 10 + 2));
}

TEST(TransformBufferThreads, readers_never_see_a_torn_sample_while_a_small_ring_is_overwritten) {
  expect_no_torn_sample({.cache_time = 10s, .samples_per_frame = 8, .most_samples_per_frame = 8, .max_frames = 10},
                        30000);
}

// From 8 to 4096.
TEST(TransformBufferThreads, readers_never_see_a_torn_sample_while_a_ring_grows) {
  for (int round = 0; round < 3; ++round)
    expect_no_torn_sample({.cache_time = 10s, .samples_per_frame = 8, .max_frames = 10}, 3000);
}

TEST(TransformBufferThreads, a_lookup_waits_for_what_another_thread_inserts) {
  TransformBuffer buffer;
  std::atomic<bool> ready{false};
  std::thread writer{[&] {
    ready.wait(false);
    EXPECT_TRUE(buffer.insert("odom", "base", at_ms(1000), at_place(1000), Permanence::Dynamic));
    EXPECT_TRUE(buffer.insert("odom", "base", at_ms(2000), at_place(2000), Permanence::Dynamic));
  }};
  EXPECT_FALSE(buffer.lookup("odom", "base", at_ms(1500), 0ms)) << "does not wait at all";
  EXPECT_EQ(buffer.lookup("odom", "base", at_ms(1500), 1ms).error().error, TransformError::Lookup);
  ready = true;
  ready.notify_one();
  const auto found = buffer.lookup("odom", "base", at_ms(1500), 1h);
  const auto through = buffer.lookup("odom", at_ms(1500), "base", at_ms(1200), "odom", 1h);
  writer.join();
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->X_TS.translation_m.x(), 1.5, 1e-6);
  ASSERT_TRUE(through);
  EXPECT_NEAR(through->X_TS.translation_m.x(), 1.2, 1e-6);
}

TEST(TransformBufferThreads, frames_may_appear_and_change_their_kind_under_readers) {
  TransformBuffer buffer;
  ASSERT_TRUE(buffer.insert("root", "f0", at_ms(0), {}, Permanence::Static));
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> wrong{0};
  std::thread reader{[&] {
    while (!stop.load()) {
      for (const char* name : {"f0", "f1", "f7", "f50"}) {
        const auto found = buffer.lookup_latest("root", name);
        if (found && !(found->X_TS.translation_m.x() >= 0 && found->X_TS.translation_m.x() <= 400)) ++wrong;
        if (!found && found.error().error != TransformError::Lookup) ++wrong;
      }
      static_cast<void>(buffer.frames());
    }
  }};
  std::thread interner{[&] {
    for (int i = 0; i < 100; ++i) static_cast<void>(buffer.intern("f" + std::to_string(i)));
  }};
  for (int i = 0; i < 400; ++i) {
    const auto kind = i % 3 == 0 ? Permanence::Static : Permanence::Dynamic;
    ASSERT_TRUE(
        buffer.insert("root", "f" + std::to_string(i % 60), at_ms(1 + i), RigidTransform::planar(i, 0, 0), kind));
  }
  interner.join();
  stop = true;
  reader.join();
  EXPECT_EQ(wrong.load(), 0U);
}

}  // namespace
}  // namespace nacelle::spatial
