// SPDX-License-Identifier: Apache-2.0
// What comes late, with and without a history.
#include <gtest/gtest.h>

#include "late_cases.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::ekf {
namespace {

constexpr std::size_t kParts = 3;
constexpr Duration kLength = 20s;

TEST(LateMeasurements, a_pose_that_comes_late_gives_the_state_of_one_in_time) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Filter in_time{late_options(kParts, std::nullopt)};
    Filter smoothed{late_options(kParts, 1s)};
    run_filter(in_time, LateDrive{seed}.measure(kLength, 0ms), kLength);
    run_filter(smoothed, LateDrive{seed}.measure(kLength, 350ms), kLength);

    EXPECT_LT(difference(in_time.belief(), smoothed.belief()), 1e-9) << "seed " << seed;
    EXPECT_EQ(smoothed.stamp(), in_time.stamp());
    const PartStats& poses = smoothed.stats(LateDrive::kPoses);
    EXPECT_EQ(poses.fused, in_time.stats(LateDrive::kPoses).fused);
    EXPECT_EQ(poses.late, poses.fused) << "each came behind newer ones";
    EXPECT_GE(poses.late_by, 340ms);
    EXPECT_LE(poses.late_by, 350ms);
    EXPECT_EQ(smoothed.stats(LateDrive::kGyro).late, 0U);
    EXPECT_TRUE(adds_up(smoothed, kParts));
  }
}

TEST(LateMeasurements, without_late_ones_a_history_changes_no_digit) {
  Filter plain{late_options(kParts, std::nullopt)};
  Filter smoothed{late_options(kParts, 1s)};
  run_filter(plain, LateDrive{}.measure(kLength, 0ms), kLength);
  run_filter(smoothed, LateDrive{}.measure(kLength, 0ms), kLength);
  EXPECT_EQ(plain.belief().mean, smoothed.belief().mean) << "bit by bit";
  EXPECT_EQ(plain.belief().covariance.matrix(), smoothed.belief().covariance.matrix());
  EXPECT_EQ(smoothed.replays().passes, 0U);
}

struct Error {
  double position_m{}, yaw_deg{};
};

Error rms_error(std::optional<Duration> history, Duration late) {
  LateDrive drive;
  const auto told = drive.measure(60s, late);
  Filter filter{late_options(kParts, history)};
  double position = 0.0;
  double yaw = 0.0;
  int count = 0;
  run_filter(filter, told, 59s, [&](Duration t) {
    const auto out = filter.output(kLateStart + t);
    if (t < 2s || !out) return;
    const LateDrive::Truth& truth = drive.truth((out->stamp - kLateStart) / 10ms * 10ms);
    const StateVector& x = out->belief->mean;
    position += std::pow(x[kX] - truth.x, 2) + std::pow(x[kY] - truth.y, 2);
    yaw += std::pow(spatial::wrap_to_pi(x[kYaw] - truth.yaw), 2);
    ++count;
  });
  return {std::sqrt(position / count), std::sqrt(yaw / count) * 180.0 / spatial::kPi};
}

TEST(LateMeasurements, going_back_takes_away_what_the_delay_costs) {
  const Error in_time = rms_error(std::nullopt, 0ms);
  const Error without = rms_error(std::nullopt, 350ms);
  const Error with = rms_error(1s, 350ms);
  std::printf("in time: %.3f m %.2f deg; 0.35 s late: %.3f m %.2f deg; with a history: %.3f m %.2f deg\n",
              in_time.position_m, in_time.yaw_deg, without.position_m, without.yaw_deg, with.position_m, with.yaw_deg);
  EXPECT_GT(without.position_m, 0.1);
  EXPECT_GT(without.yaw_deg, 3.0);
  EXPECT_LT(with.position_m, 0.03);
  EXPECT_LT(with.yaw_deg, 0.6);
}

TEST(LateMeasurements, what_is_older_than_the_history_is_counted_and_not_fused) {
  Filter filter{late_options(kParts, 200ms)};
  Filter without_poses{late_options(kParts, std::nullopt)};
  auto told = LateDrive{}.measure(5s, 350ms);
  run_filter(filter, told, 5s);
  std::erase_if(told, [](const Told& t) { return t.part == LateDrive::kPoses; });
  run_filter(without_poses, told, 5s);

  const PartStats& poses = filter.stats(LateDrive::kPoses);
  EXPECT_EQ(poses.fused, 0U);
  EXPECT_EQ(poses.of(Rejection::BeforeHistory), poses.received);
  EXPECT_GT(poses.late_by, 200ms);
  EXPECT_EQ(filter.belief().mean, without_poses.belief().mean);
  EXPECT_TRUE(adds_up(filter, kParts));
}

TEST(LateMeasurements, an_input_whose_own_stamps_go_back_is_refused_as_before) {
  Filter filter{late_options(kParts, 1s)};
  auto told = LateDrive{}.measure(2s, 100ms);
  for (Told& t : told) {
    if (t.part == LateDrive::kPoses && t.stamp == 500ms) t.arrives = 1s;  // behind its successors
  }
  run_filter(filter, told, 2s);
  EXPECT_EQ(filter.stats(LateDrive::kPoses).of(Rejection::Stale), 1U);
  EXPECT_TRUE(adds_up(filter, kParts));
}

/// All poses of two seconds come at once.
std::vector<Told> with_a_burst(Duration length) {
  auto told = LateDrive{}.measure(length, 0ms);
  for (Told& t : told) {
    if (t.part == LateDrive::kPoses && t.stamp > 4s && t.stamp <= 6s) t.arrives = 6s;
  }
  return told;
}

TEST(LateMeasurements, a_burst_is_one_pass) {
  Filter filter{late_options(kParts, 3s)};
  FilterOptions patient = late_options(kParts, 3s);
  patient.replay_instructions = 1'000'000'000;
  Filter at_once{patient};
  run_filter(at_once, with_a_burst(8s), 8s);
  EXPECT_EQ(at_once.replays().passes, 1U);
  EXPECT_LT(at_once.replays().measurements, 400U) << "two seconds of them";
}

TEST(LateMeasurements, a_pass_that_is_too_long_for_a_step_goes_on_in_the_next_ones) {
  Filter in_time{late_options(kParts, std::nullopt)};
  run_filter(in_time, LateDrive{}.measure(8s, 0ms), 8s);
  FilterOptions few = late_options(kParts, 3s);
  few.replay_instructions = 200'000;  // some twenty
  Filter filter{few};
  std::uint64_t before = 0;
  std::uint64_t most = 0;
  int outputs = 0;
  run_filter(filter, with_a_burst(8s), 8s, [&](Duration t) {
    most = std::max(most, filter.replays().measurements - before);
    before = filter.replays().measurements;
    const auto out = filter.output(kLateStart + t);
    ASSERT_TRUE(out.has_value());
    EXPECT_EQ(out->stamp, kLateStart + t) << "the newest measurement is in every output";
    ++outputs;
    EXPECT_TRUE(adds_up(filter, kParts));
  });
  EXPECT_EQ(outputs, 401);
  EXPECT_GT(filter.replays().continued, 5U);
  EXPECT_LT(most, 30U) << "per step";
  EXPECT_LT(difference(in_time.belief(), filter.belief()), 1e-9);
}

TEST(LateMeasurements, late_ones_that_come_during_a_pass_do_not_keep_it_from_ending) {
  Filter in_time{late_options(kParts, std::nullopt)};
  run_filter(in_time, LateDrive{}.measure(kLength, 0ms), kLength);
  FilterOptions few = late_options(kParts, 1s);
  few.replay_instructions = 60'000;  // a pass takes more steps than the poses have between them
  Filter filter{few};
  std::uint64_t continued = 0;
  auto told = LateDrive{}.measure(kLength, 350ms);
  run_filter(filter, told, kLength, [&](Duration t) {
    if (t == kLength / 2) continued = filter.replays().continued;
  });
  EXPECT_GT(continued, 300U) << "nearly every step";
  EXPECT_GT(filter.replays().passes, 50U);
  EXPECT_TRUE(adds_up(filter, kParts));
  // Without new poses it catches up with what it was told.
  for (Duration t = kLength + 20ms; t <= kLength + 2s; t += 20ms) filter.step(kLateStart + t, MonotonicTime{1s + t});
  EXPECT_FALSE(filter.history()->pending());
  EXPECT_EQ(filter.stats(LateDrive::kPoses).waiting, 0U);
}

TEST(LateMeasurements, a_running_filter_with_a_history_allocates_nothing) {
  Filter filter{late_options(kParts, 1s)};
  auto told = LateDrive{}.measure(10s, 350ms);
  std::uint64_t before = 0;
  std::optional<test::AllocationGuard> guard;
  run_filter(filter, told, 9s, [&](Duration t) {
    static_cast<void>(filter.output(kLateStart + t));
    if (t == 3s) guard.emplace();
    if (t == 9s) before = guard->count();
  });
  EXPECT_EQ(before, 0U);
  EXPECT_GT(filter.replays().passes, 80U);
}

TEST(LateMeasurements, what_does_not_fit_makes_the_history_shorter_and_is_counted) {
  FilterOptions small = late_options(kParts, 3s);
  small.queue_limit = 64;
  small.replay_instructions = 60'000;
  Filter filter{small};
  run_filter(filter, LateDrive{}.measure(10s, 350ms), 10s);
  EXPECT_GT(filter.history()->cut_short(), 100U);
  EXPECT_LE(filter.history()->kept(), 64U);
  EXPECT_LT(filter.history()->reach(), 500ms);
  EXPECT_TRUE(adds_up(filter, kParts));
  EXPECT_GT(filter.stats(LateDrive::kPoses).fused, 50U);
}

TEST(LateMeasurements, a_command_is_the_one_of_its_time_when_the_filter_goes_back) {
  FilterOptions driven = late_options(kParts, 1s);
  driven.control.controlled = {true, false, false, false, false, true};
  driven.control.timeout = 200ms;
  const auto command = [](Filter& filter, Duration t) {
    const double s = to_seconds(t);
    filter.command({0.4 + 0.2 * std::sin(0.7 * s), 0, 0, 0, 0, 0.5 * std::sin(0.9 * s)}, kLateStart + t);
  };
  Filter in_time{driven};
  Filter smoothed{driven};
  run_filter(in_time, LateDrive{}.measure(5s, 0ms), 5s, [&](Duration t) { command(in_time, t); });
  run_filter(smoothed, LateDrive{}.measure(5s, 350ms), 5s, [&](Duration t) { command(smoothed, t); });
  EXPECT_GT(smoothed.replays().passes, 40U);
  EXPECT_LT(difference(in_time.belief(), smoothed.belief()), 1e-9);
}

TEST(LateMeasurements, a_slow_input_with_a_delay_is_fused_with_a_short_history) {
  Filter filter{late_options(1, 300ms)};
  std::vector<Told> told;
  for (int i = 0; i < 20; ++i) {
    Told& t = told.emplace_back(Told{1s * i, 1s * i + 70ms, 0, {}});
    t.reading.add(kVx, 0.5, 1e-3);
  }
  run_filter(filter, told, 20s);
  EXPECT_EQ(filter.stats(0).fused, 20U);
  EXPECT_NEAR(filter.belief().mean[kX], 10.0, 0.1);
}

TEST(LateMeasurements, set_pose_reset_and_a_clock_that_is_set_end_the_history) {
  const auto late_pose = [](Filter& filter, Duration stamp, Duration now) {
    filter.offer(LateDrive::kPoses, kLateStart + stamp, kLateStart + now, [](Reading& r) -> Prepared {
      r.rows = 0;
      r.add(kX, 100.0, 1e-6);
      return {};
    });
  };
  const auto driven = [](Filter& filter) {
    auto told = LateDrive{}.measure(3s, 100ms);
    std::erase_if(told, [](const Told& t) { return t.part == LateDrive::kPoses; });
    run_filter(filter, told, 3s);
  };
  Filter posed{late_options(kParts, 2s)};
  driven(posed);
  Reading pose;
  pose.add(kX, 7.0, 0.01);
  ASSERT_TRUE(posed.set_pose(pose, kLateStart + 3s));
  late_pose(posed, 2900ms, 3010ms);
  posed.step(kLateStart + 3020ms, MonotonicTime{4020ms});
  EXPECT_EQ(posed.stats(LateDrive::kPoses).of(Rejection::BeforeSetPose), 1U);
  EXPECT_NEAR(posed.belief().mean[kX], 7.0, 0.1);

  Filter fresh{late_options(kParts, 2s)};
  driven(fresh);
  fresh.reset();
  EXPECT_FALSE(fresh.initialised());
  EXPECT_EQ(fresh.history()->kept(), 0U);

  Filter ahead{late_options(kParts, 2s)};
  driven(ahead);
  ahead.offer(LateDrive::kGyro, kLateStart + 60s, kLateStart + 60s, [](Reading& r) -> Prepared {
    r.rows = 0;
    r.add(kVyaw, 0.1, 1e-4);
    return {};
  });
  ahead.step(kLateStart + 60s, MonotonicTime{4020ms});
  EXPECT_EQ(ahead.clock_steps(), 1U);
  late_pose(ahead, 59s, 60010ms);
  ahead.step(kLateStart + 60020ms, MonotonicTime{4040ms});
  EXPECT_EQ(ahead.stats(LateDrive::kPoses).of(Rejection::BeforeHistory), 1U) << "the clock was set since then";
  EXPECT_LT(ahead.belief().mean[kX], 5.0);
  EXPECT_TRUE(adds_up(ahead, kParts));

  Filter back{late_options(kParts, 2s)};
  driven(back);
  const double x = back.belief().mean[kX];
  back.step(kLateStart - 60s, MonotonicTime{4020ms});
  EXPECT_EQ(back.history()->kept(), 0U);
  EXPECT_EQ(back.belief().mean[kX], x) << "the estimate holds";
}

TEST(TimeJump, resets_the_filter_only_where_it_is_told_to) {
  for (const bool resets : {true, false}) {
    FilterOptions o = late_options(kParts, std::nullopt);
    o.reset_on_time_jump = resets;
    Filter filter{o};
    run_filter(filter, LateDrive{}.measure(3s, 0ms), 3s);
    ASSERT_TRUE(filter.output(kLateStart + 3s).has_value());
    filter.step(kLateStart + 1s);
    EXPECT_EQ(filter.initialised(), !resets);
    EXPECT_EQ(filter.time_resets(), resets ? 1U : 0U);
    filter.offer(LateDrive::kWheels, kLateStart + 1010ms, kLateStart + 1010ms, [](Reading& r) -> Prepared {
      r.rows = 0;
      r.add(kVx, 0.5, 1e-3);
      return {};
    });
    filter.step(kLateStart + 1020ms);
    ASSERT_TRUE(filter.output(kLateStart + 1020ms).has_value()) << "it begins anew";
    if (resets) {
      EXPECT_EQ(filter.belief().mean[kX], 0.0);
    } else {
      EXPECT_GT(filter.belief().mean[kX], 0.5);
    }
  }
}

TEST(CorrectedPublication, gives_the_corrected_state_at_its_own_stamp_where_it_is_permitted) {
  for (const bool permitted : {true, false}) {
    FilterOptions o = late_options(kParts, 1s);
    o.permit_corrected_publication = permitted;
    o.sensor_timeout = 100ms;  // a prediction to now has a newer stamp
    Filter filter{o};
    auto told = LateDrive{}.measure(2s, 0ms);
    std::erase_if(told, [](const Told& t) { return t.part == LateDrive::kPoses; });
    run_filter(filter, told, 2s, [&](Duration t) { static_cast<void>(filter.output(kLateStart + t)); });
    const WallTime told_last = filter.stamp();
    filter.offer(LateDrive::kPoses, kLateStart + 1700ms, kLateStart + 2010ms, [](Reading& r) -> Prepared {
      r.rows = 0;
      r.add(kX, 3.0, 1e-4);
      return {};
    });
    filter.step(kLateStart + 2020ms, MonotonicTime{3020ms});
    const auto corrected = filter.output(kLateStart + 2020ms);
    ASSERT_TRUE(corrected.has_value());
    EXPECT_EQ(corrected->stamp, permitted ? told_last : kLateStart + 2020ms);
    filter.step(kLateStart + 2040ms, MonotonicTime{3040ms});
    const auto next = filter.output(kLateStart + 2040ms);
    ASSERT_TRUE(next.has_value());
    EXPECT_EQ(next->stamp, kLateStart + 2040ms) << "once";
  }
}

}  // namespace
}  // namespace nacelle::ekf
