// SPDX-License-Identifier: Apache-2.0
#include "nacelle/spatial/transform_buffer.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>

#include "support/allocation_guard.hpp"

namespace nacelle::spatial {
namespace {

WallTime at(double seconds) { return WallTime{from_seconds(seconds)}; }

class Buffer : public ::testing::Test {
 public:
  Result<void, InsertFault> put(const char* parent, const char* child, double t, double x, double yaw = 0) {
    return buffer_.insert(parent, child, at(t), RigidTransform::planar(x, 0, yaw), Permanence::Dynamic);
  }
  void put_static(const char* parent, const char* child, double x, double yaw = 0) {
    ASSERT_TRUE(buffer_.insert(parent, child, at(0), RigidTransform::planar(x, 0, yaw), Permanence::Static));
  }
  double x_of(const char* target, const char* source, double t) {
    const auto found = buffer_.lookup(target, source, at(t));
    EXPECT_TRUE(found) << (found ? "" : found.error().text());
    return found ? found->X_TS.translation_m.x() : std::numeric_limits<double>::quiet_NaN();
  }
  LookupFault fault_of(const char* target, const char* source, double t) {
    const auto found = buffer_.lookup(target, source, at(t));
    EXPECT_FALSE(found);
    return found ? LookupFault{} : found.error();
  }
  TransformBuffer buffer_;
};

TEST_F(Buffer, interpolates_between_neighbours_and_returns_samples_at_their_own_time) {
  ASSERT_TRUE(put("odom", "base", 1.0, 10.0, 0.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 20.0, 1.0));

  EXPECT_DOUBLE_EQ(x_of("odom", "base", 1.0), 10.0);
  EXPECT_DOUBLE_EQ(x_of("odom", "base", 2.0), 20.0);
  EXPECT_NEAR(x_of("odom", "base", 1.25), 12.5, 1e-12);
  EXPECT_NEAR(yaw_from_quaternion(buffer_.lookup("odom", "base", at(1.25))->X_TS.rotation), 0.25, 1e-12);
}

TEST_F(Buffer, gives_the_inverse_when_asked_the_other_way_round) {
  ASSERT_TRUE(put("odom", "base", 1.0, 3.0, 0.5));
  put_static("base", "laser", 0.2, 0.1);

  const auto there = buffer_.lookup("odom", "laser", at(1.0));
  const auto back = buffer_.lookup("laser", "odom", at(1.0));

  EXPECT_LT(((there->X_TS * back->X_TS).isometry().matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-14);
}

TEST_F(Buffer, joins_two_branches_at_their_common_ancestor) {
  put_static("base", "left", 1.0);
  put_static("base", "right", -1.0);
  put_static("left", "left_tip", 0.5);

  EXPECT_DOUBLE_EQ(x_of("right", "left_tip", 5.0), 2.5);
  EXPECT_DOUBLE_EQ(x_of("left_tip", "right", 5.0), -2.5);
  EXPECT_DOUBLE_EQ(x_of("base", "base", 5.0), 0.0);
}

TEST_F(Buffer, time_zero_is_the_latest_time_that_the_whole_chain_has_reached) {
  for (const double t : {1.0, 2.0, 3.0}) ASSERT_TRUE(put("odom", "base", t, 10.0 * t));
  for (const double t : {1.5, 2.5}) ASSERT_TRUE(put("base", "arm", t, 0.0));

  const auto found = buffer_.lookup("odom", "arm", at(0));

  ASSERT_TRUE(found);
  EXPECT_EQ(found->stamp, at(2.5));
  EXPECT_NEAR(found->X_TS.translation_m.x(), 25.0, 1e-12);
}

TEST_F(Buffer, time_zero_of_a_static_chain_is_time_zero) {
  put_static("base", "laser", 1.0);
  EXPECT_EQ(buffer_.lookup_latest("base", "laser")->stamp, WallTime{});
}

TEST_F(Buffer, refuses_to_extrapolate_and_names_both_times) {
  ASSERT_TRUE(put("odom", "base", 1.0, 0.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 0.0));

  const auto early = fault_of("odom", "base", 0.5);
  EXPECT_EQ(early.error, TransformError::BackwardExtrapolation);
  EXPECT_EQ(early.requested, at(0.5));
  EXPECT_EQ(early.available, at(1.0));
  EXPECT_NE(
      early.text().find("Lookup would require extrapolation into the past.  Requested time 0.500000 but the earliest "
                        "data is at time 1.000000, when looking up transform from frame [base] to frame [odom]"),
      std::string::npos)
      << early.text();
  const auto late = fault_of("odom", "base", 2.5);
  EXPECT_EQ(late.error, TransformError::ForwardExtrapolation);
  EXPECT_NE(late.text().find(
                "extrapolation into the future.  Requested time 2.500000 but the latest data is at time 2.000000"),
            std::string::npos)
      << late.text();
}

TEST_F(Buffer, names_the_other_machines_clock_that_keeps_a_frame_back) {
  const auto skews = std::make_shared<ClockSkews>();
  skews->replace({{7, ClockSkew{"laptop", -150ms}}});
  buffer_.explain_by(skews);
  for (const double t : {1.0, 2.0}) {
    ASSERT_TRUE(buffer_.insert("map", "odom", at(t), {}, Permanence::Dynamic, 7));
    ASSERT_TRUE(put("hall", "dock", t, 0.0));
  }

  EXPECT_NE(fault_of("map", "odom", 2.1)
                .text()
                .find("(at frame [odom]); clock skew: host laptop is 150 ms behind, or its messages come that late"),
            std::string::npos)
      << fault_of("map", "odom", 2.1).text();
  EXPECT_EQ(fault_of("hall", "dock", 2.1).text().find("skew"), std::string::npos);
  skews->replace({});
  EXPECT_EQ(fault_of("map", "odom", 2.1).text().find("skew"), std::string::npos);
}

TEST_F(Buffer, one_sample_holds_for_its_own_time_only) {
  ASSERT_TRUE(put("odom", "base", 1.0, 7.0));

  EXPECT_DOUBLE_EQ(x_of("odom", "base", 1.0), 7.0);
  const auto fault = fault_of("odom", "base", 1.1);
  EXPECT_EQ(fault.error, TransformError::NoDataForExtrapolation);
  EXPECT_NE(
      fault.text().find("Lookup would require extrapolation at time 1.100000, but only time 1.000000 is in the buffer"),
      std::string::npos)
      << fault.text();
}

TEST_F(Buffer, names_the_frame_whose_history_ends) {
  ASSERT_TRUE(put("odom", "base", 1.0, 0.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 0.0));
  ASSERT_TRUE(put("base", "arm", 1.0, 0.0));
  ASSERT_TRUE(put("base", "arm", 1.5, 0.0));
  EXPECT_EQ(fault_of("odom", "arm", 1.8).broken_at.view(), "arm");
  EXPECT_EQ(fault_of("arm", "odom", 1.8).broken_at.view(), "arm");
}

TEST_F(Buffer, an_unknown_frame_is_a_lookup_fault_even_if_its_name_was_interned) {
  put_static("base", "laser", 0.0);
  const FrameId waiting = buffer_.intern("imu");

  EXPECT_EQ(fault_of("base", "imu", 1.0).error, TransformError::Lookup);
  EXPECT_EQ(buffer_.lookup(buffer_.find("base"), waiting, at(1.0)).error().error, TransformError::Lookup);
  EXPECT_EQ(fault_of("base", "gripper", 1.0).text(),
            "\"gripper\" passed to lookupTransform argument source_frame does not exist.");
}

TEST_F(Buffer, empty_and_slashed_names_are_invalid_arguments) {
  put_static("/base", "/laser", 2.0);  // one slash is stripped when it comes from a broadcaster
  EXPECT_DOUBLE_EQ(x_of("base", "laser", 1.0), 2.0);
  EXPECT_EQ(fault_of("", "laser", 1.0).error, TransformError::InvalidArgument);
  const auto slashed = fault_of("/base", "laser", 1.0);
  EXPECT_EQ(slashed.error, TransformError::InvalidArgument);
  EXPECT_EQ(
      slashed.text(),
      "Invalid argument \"/base\" passed to lookupTransform argument target_frame - in tf2 frame_ids cannot start with "
      "a '/'");
}

// Source: tf2, BufferCore::lookupTransformImpl: the identity is not validated, and time 0 is the frame's newest.
TEST_F(Buffer, the_transform_of_a_frame_to_itself_is_the_identity_even_if_it_is_unknown) {
  for (const char* name : {"nobody", "", "/slashed"}) {
    const auto then = buffer_.lookup(name, name, at(3.0));
    ASSERT_TRUE(then) << name;
    EXPECT_EQ(then->stamp, at(3.0));
    EXPECT_TRUE(then->X_TS.translation_m.isZero());
    EXPECT_EQ(buffer_.lookup_latest(name, name)->stamp, WallTime{});
  }
  ASSERT_TRUE(put("odom", "base", 1.0, 10.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 20.0));
  put_static("base", "laser", 0.5);
  EXPECT_EQ(buffer_.lookup_latest("base", "base")->stamp, at(2.0));
  EXPECT_EQ(buffer_.lookup_latest(buffer_.find("base"), buffer_.find("base"))->stamp, at(2.0));
  EXPECT_EQ(buffer_.lookup("base", "base", at(9.0))->stamp, at(9.0));
  EXPECT_EQ(buffer_.lookup_latest("laser", "laser")->stamp, WallTime{});
  EXPECT_EQ(buffer_.lookup_latest("odom", "odom")->stamp, WallTime{});
  EXPECT_FALSE(buffer_.lookup(buffer_.find("nobody"), buffer_.find("else"), at(1.0)))
      << "two unknown frames are not one";
}

TEST_F(Buffer, a_fixed_frame_joins_two_times) {
  ASSERT_TRUE(put("odom", "base", 1.0, 10.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 14.0));
  put_static("base", "laser", 0.5);
  // Where the laser of t = 1 is, seen from the base of t = 2: 4 m behind its place.
  const auto found = buffer_.lookup("base", at(2.0), "laser", at(1.0), "odom");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_DOUBLE_EQ(found->X_TS.translation_m.x(), -3.5);
  EXPECT_EQ(found->stamp, at(2.0));
  EXPECT_EQ(buffer_.lookup("base", at(2.0), "laser", at(0.5), "odom").error().error,
            TransformError::BackwardExtrapolation);
  const auto unknown = buffer_.lookup("base", at(2.0), "laser", at(1.0), "map");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().text(), "\"map\" passed to lookupTransform argument fixed_frame does not exist.");
  EXPECT_FALSE(buffer_.lookup("nobody", at(2.0), "nobody", at(1.0), "odom")) << "here tf2 validates all three";
}

TEST_F(Buffer, the_thread_that_feeds_the_buffer_is_not_let_wait_for_itself) {
  ASSERT_TRUE(put("odom", "base", 1.0, 10.0));
  const auto found = buffer_.lookup("odom", "base", at(2.0), 1h);
  ASSERT_FALSE(found);
  EXPECT_TRUE(found.error().would_starve);
  EXPECT_NE(found.error().text().find("this thread feeds the buffer"), std::string::npos) << found.error().text();
}

TEST_F(Buffer, two_trees_have_no_connection) {
  put_static("a", "b", 0.0);
  put_static("c", "d", 0.0);
  const auto fault = fault_of("b", "d", 1.0);
  EXPECT_EQ(fault.error, TransformError::Connectivity);
  EXPECT_EQ(buffer_.lookup_latest("b", "d").error().error, TransformError::Connectivity);
  EXPECT_NE(fault.text().find("Could not find a connection between 'b' and 'd'"), std::string::npos);
}

TEST_F(Buffer, a_loop_is_reported_instead_of_walked_for_ever) {
  put_static("a", "b", 0.0);
  put_static("b", "c", 0.0);
  put_static("c", "a", 0.0);
  put_static("x", "y", 0.0);
  EXPECT_EQ(fault_of("y", "a", 1.0).error, TransformError::Transform);
  EXPECT_EQ(buffer_.lookup_latest("y", "a").error().error, TransformError::Transform);
}

TEST_F(Buffer, rejects_what_is_no_transform_and_counts_each_cause) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RigidTransform bad;
  bad.translation_m.x() = nan;
  RigidTransform long_q;
  long_q.rotation.coeffs() *= 1.006;  // |q|^2 = 1.012
  RigidTransform near_q;
  near_q.rotation.coeffs() *= 1.004;  // |q|^2 = 1.008: tolerated and mended

  EXPECT_EQ(buffer_.insert("a", "a", at(1), {}, Permanence::Dynamic).error(), InsertFault::SelfTransform);
  EXPECT_EQ(buffer_.insert("a", "/a", at(1), {}, Permanence::Dynamic).error(), InsertFault::SelfTransform);
  EXPECT_EQ(buffer_.insert("", "a", at(1), {}, Permanence::Dynamic).error(), InsertFault::EmptyFrame);
  EXPECT_EQ(buffer_.insert("a", "", at(1), {}, Permanence::Dynamic).error(), InsertFault::EmptyFrame);
  EXPECT_EQ(buffer_.insert("a", "b", at(1), bad, Permanence::Dynamic).error(), InsertFault::NotFinite);
  EXPECT_EQ(buffer_.insert("a", "b", at(1), long_q, Permanence::Dynamic).error(), InsertFault::NotNormalised);
  EXPECT_TRUE(buffer_.insert("a", "b", at(1), near_q, Permanence::Dynamic));
  EXPECT_NEAR(buffer_.lookup("a", "b", at(1))->X_TS.rotation.norm(), 1.0, 1e-15);

  const auto stats = buffer_.stats();
  EXPECT_EQ(stats.self_transform, 2U);
  EXPECT_EQ(stats.empty_frame, 2U);
  EXPECT_EQ(stats.not_finite, 1U);
  EXPECT_EQ(stats.not_normalised, 1U);
  EXPECT_EQ(stats.inserted, 1U);
}

TEST_F(Buffer, keeps_ten_seconds_seen_from_the_newest_sample) {
  for (int i = 0; i <= 200; ++i) ASSERT_TRUE(put("odom", "base", 100.0 + 0.1 * i, i));

  EXPECT_EQ(fault_of("odom", "base", 109.95).error, TransformError::BackwardExtrapolation);
  EXPECT_NEAR(x_of("odom", "base", 110.05), 100.5, 1e-6);
  EXPECT_EQ(put("odom", "base", 109.9, 0.0).error(), InsertFault::TooOld);
  EXPECT_EQ(buffer_.stats().too_old, 1U);
}

TEST_F(Buffer, sorts_late_samples_in_and_ignores_exact_repeats) {
  ASSERT_TRUE(put("odom", "base", 1.0, 10.0));
  ASSERT_TRUE(put("odom", "base", 3.0, 30.0));
  EXPECT_NEAR(x_of("odom", "base", 1.5), 15.0, 1e-12);

  ASSERT_TRUE(put("odom", "base", 2.0, 0.0));
  ASSERT_TRUE(put("odom", "base", 0.5, 5.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 0.0));

  EXPECT_NEAR(x_of("odom", "base", 1.5), 5.0, 1e-12);
  EXPECT_NEAR(x_of("odom", "base", 0.75), 7.5, 1e-12);
  EXPECT_EQ(buffer_.stats().duplicates, 1U);
  EXPECT_EQ(buffer_.frames().at(0).samples, 4U);
}

TEST_F(Buffer, a_later_word_about_the_same_instant_wins) {
  ASSERT_TRUE(put("odom", "base", 1.0, 10.0));
  ASSERT_TRUE(put("odom", "base", 2.0, 20.0));
  ASSERT_TRUE(put("odom", "base", 1.0, 12.0));
  EXPECT_DOUBLE_EQ(x_of("odom", "base", 1.0), 12.0);
}

TEST_F(Buffer, a_new_parent_takes_over_and_nothing_is_interpolated_across_the_change) {
  put_static("world", "table", 100.0);
  put_static("world", "hand", 200.0);
  ASSERT_TRUE(put("table", "cup", 1.0, 1.0));
  ASSERT_TRUE(put("table", "cup", 2.0, 2.0));
  ASSERT_TRUE(put("hand", "cup", 3.0, 3.0));
  ASSERT_TRUE(put("hand", "cup", 4.0, 4.0));

  EXPECT_NEAR(x_of("world", "cup", 1.5), 101.5, 1e-12);
  EXPECT_NEAR(x_of("world", "cup", 2.5), 102.0, 1e-12) << "the older sample holds until the next";
  EXPECT_NEAR(x_of("world", "cup", 3.5), 203.5, 1e-12);
  EXPECT_EQ(buffer_.lookup_latest("world", "cup")->stamp, at(4.0));
}

TEST_F(Buffer, a_frame_that_becomes_static_forgets_its_samples_and_back) {
  ASSERT_TRUE(put("base", "arm", 1.0, 1.0));
  ASSERT_TRUE(put("base", "arm", 2.0, 2.0));
  put_static("base", "arm", 9.0);
  EXPECT_DOUBLE_EQ(x_of("base", "arm", 50.0), 9.0);
  ASSERT_TRUE(put("base", "arm", 60.0, 6.0));
  EXPECT_EQ(fault_of("base", "arm", 1.5).error, TransformError::NoDataForExtrapolation);
}

TEST_F(Buffer, clear_forgets_frames_but_not_their_numbers) {
  put_static("base", "arm", 1.0);
  const FrameId arm = buffer_.find("arm");
  buffer_.clear();
  EXPECT_EQ(fault_of("base", "arm", 1.0).error, TransformError::Lookup);
  put_static("base", "arm", 2.0);
  EXPECT_EQ(buffer_.find("arm"), arm);
  EXPECT_DOUBLE_EQ(x_of("base", "arm", 1.0), 2.0);
}

TEST(BufferLimits, endless_names_fill_a_table_and_not_the_memory) {
  TransformBuffer buffer{{.cache_time = 10s, .samples_per_frame = 4, .max_frames = 10}};
  for (int i = 0; i < 100; ++i) {
    const bool taken = buffer.insert("root", "f" + std::to_string(i), at(1), {}, Permanence::Static).has_value();
    EXPECT_EQ(taken, i < 9);
  }
  EXPECT_EQ(buffer.stats().too_many_frames, 91U);
}

TEST(BufferLimits, a_rate_above_the_rings_keeps_the_newest_samples) {
  TransformBuffer buffer{{.cache_time = 10s, .samples_per_frame = 8, .most_samples_per_frame = 8, .max_frames = 10}};
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(buffer.insert("a", "b", at(1 + 0.01 * i), RigidTransform::planar(i, 0, 0), Permanence::Dynamic));
  }
  EXPECT_NEAR(buffer.lookup("a", "b", at(1.935))->X_TS.translation_m.x(), 93.5, 1e-6);
  EXPECT_EQ(buffer.lookup("a", "b", at(1.91)).error().error, TransformError::BackwardExtrapolation);
  EXPECT_EQ(buffer.frames().at(0).samples, 7U);
  EXPECT_EQ(buffer.insert("a", "b", at(1.925), {}, Permanence::Dynamic).error(), InsertFault::TooOld)
      << "no room at the old end";
}

TEST(BufferLimits, ten_seconds_are_kept_at_a_thousand_hertz) {
  TransformBuffer buffer;
  const auto put = [&](int ms) {
    return buffer.insert("odom", "base", at(1 + 1e-3 * ms), RigidTransform::planar(ms, 0, 0), Permanence::Dynamic)
        .has_value();
  };
  for (int ms = 0; ms <= 10'000; ++ms) ASSERT_TRUE(put(ms));
  EXPECT_EQ(buffer.frames().at(0).samples, 10'001U);
  EXPECT_NEAR(buffer.lookup("odom", "base", at(1.0005))->X_TS.translation_m.x(), 0.5, 1e-6);

  // Once it is as large as the rate needs, nothing is allocated any more.
  const test::AllocationGuard guard;
  for (int ms = 10'001; ms <= 40'000; ++ms) ASSERT_TRUE(put(ms));
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(buffer.lookup("odom", "base", at(30.9)).error().error, TransformError::BackwardExtrapolation);
  EXPECT_NEAR(buffer.lookup("odom", "base", at(31.0005))->X_TS.translation_m.x(), 30'000.5, 1e-5);
}

TEST(BufferLimits, a_slow_frame_takes_no_more_room_than_at_first) {
  TransformBuffer buffer{{.cache_time = 10s, .samples_per_frame = 128, .max_frames = 10}};
  ASSERT_TRUE(buffer.insert("odom", "base", at(0.9), {}, Permanence::Dynamic));
  const test::AllocationGuard guard;
  for (int i = 0; i < 1000; ++i)
    ASSERT_TRUE(buffer.insert("odom", "base", at(1 + 0.1 * i), RigidTransform::planar(i, 0, 0), Permanence::Dynamic));
  EXPECT_EQ(guard.count(), 0U);
}

// The same questions to a plain model: a sorted map per frame, searched one after another.
TEST(BufferLaws, answers_as_a_sorted_map_does_for_any_order_of_samples) {
  const unsigned seed = 4711;
  std::mt19937 random{seed};
  std::uniform_int_distribution<int> tick{0, 1999};
  TransformBuffer buffer;
  std::map<int, double> model;
  int newest = 0;
  for (int i = 0; i < 6000; ++i) {
    const int t = std::max(0, i / 3 - tick(random) / 10);  // up to 0.2 s late on a line of 1 ms ticks
    const double x = i;
    const bool taken =
        buffer.insert("odom", "base", at(1 + 1e-3 * t), RigidTransform::planar(x, 0, 0), Permanence::Dynamic)
            .has_value();
    newest = std::max(newest, t);
    if (taken) model[t] = x;

    const double q = std::uniform_real_distribution<double>{newest - 1200.0, newest + 20.0}(random);
    const auto found = buffer.lookup("odom", "base", at(1 + 1e-3 * q));
    const auto after = model.lower_bound(static_cast<int>(std::ceil(q)));
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", step " << i << ", query " << q);
    if (model.size() < 2) continue;
    if (q > model.rbegin()->first) {
      ASSERT_EQ(found.error().error, TransformError::ForwardExtrapolation);
    } else if (q < model.begin()->first) {
      ASSERT_EQ(found.error().error, TransformError::BackwardExtrapolation);
    } else {
      const auto before = std::prev(after);
      const double ratio = (q - before->first) / (after->first - before->first);
      ASSERT_TRUE(found) << found.error().text();
      EXPECT_NEAR(found->X_TS.translation_m.x(), before->second + ratio * (after->second - before->second), 0.02);
    }
  }
}

TEST(BufferAllocations, lookups_and_repeated_inserts_allocate_nothing) {
  TransformBuffer buffer;
  const FrameId odom = buffer.intern("odom"), base = buffer.intern("base"), tip = buffer.intern("tip");
  ASSERT_TRUE(buffer.insert(base, tip, at(0), {}, Permanence::Static));
  ASSERT_TRUE(buffer.insert(odom, base, at(1), {}, Permanence::Dynamic));
  double sum = 0;
  std::uint64_t faults = 0;

  const test::AllocationGuard guard;
  for (int i = 1; i < 3000; ++i) {
    sum += buffer.insert(odom, base, at(1 + 0.02 * i), RigidTransform::planar(i, 0, 0), Permanence::Dynamic) ? 1 : 0;
    sum += buffer.insert("odom", "base", at(1 + 0.02 * i - 0.01), RigidTransform::planar(i, 0, 0), Permanence::Dynamic)
               ? 1
               : 0;
    sum += buffer.lookup("odom", "tip", at(1 + 0.02 * i - 0.005)) ? 1 : 0;
    sum += buffer.lookup_latest(odom, tip) ? 1 : 0;
    faults += buffer.lookup("odom", "nobody", at(2)) ? 0 : 1;
    faults += buffer.lookup("odom", "tip", at(1 + 0.02 * i + 0.005)) ? 0 : 1;
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(sum, 4 * 2999);
  EXPECT_EQ(faults, 2U * 2999U);
}

}  // namespace
}  // namespace nacelle::spatial
