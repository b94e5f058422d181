// SPDX-License-Identifier: Apache-2.0
#include "lidar/model/scan_assembler.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lidar/protocol/ld_protocol.hpp"
#include "simulation/model/sensor_models.hpp"

namespace nacelle::lidar {
namespace {

constexpr double kPi = std::numbers::pi;

MonotonicTime at(double seconds) { return {from_seconds(seconds)}; }

/// Turns of twelve-beam sweeps, 0.8 deg a step, 10 turns/s.
struct Turntable {
  float range_m = 1.0F;
  double angle_deg = 0.0;
  double time_s = 100.0;
  std::array<Beam, 12> beams{};
  static constexpr double kStepDeg = 0.8, kPointS = 0.8 / 3600.0;

  Sweep next() {
    for (std::size_t i = 0; i < beams.size(); ++i) {
      const double at_deg = std::fmod(angle_deg + static_cast<double>(i) * kStepDeg, 360.0);
      beams[i] = {static_cast<float>(at_deg), range_m, 200.0F};
    }
    const Sweep sweep{.beams = beams,
                      .first_rotor_deg = angle_deg,
                      .rotor_step_deg = kStepDeg,
                      .period = from_seconds(kPointS),
                      .speed_dps = 3600.0,
                      .has_intensities = true};
    angle_deg = std::fmod(angle_deg + 12 * kStepDeg, 360.0);
    time_s += 12 * kPointS;
    return sweep;
  }
  /// When the last beam of the sweep that next() gave was measured.
  [[nodiscard]] MonotonicTime last_beam() const { return at(time_s - kPointS); }
};

std::vector<Scan> scans_of(ScanAssembler& assembler, Turntable& table, int sweeps) {
  std::vector<Scan> scans;
  for (int i = 0; i < sweeps; ++i) {
    const Sweep sweep = table.next();
    assembler.add(sweep, table.last_beam(), [&](const Scan& scan) { scans.push_back(scan); });
  }
  return scans;
}

TEST(ScanAssembler, every_scan_has_the_asked_number_of_rays_whatever_the_speed) {
  for (const std::size_t points : {1U, 360U, 450U, 455U, 1000U}) {
    ScanAssembler assembler{{.points = points}};
    Turntable table;
    const auto scans = scans_of(assembler, table, 200);
    ASSERT_GE(scans.size(), 3U);
    for (const Scan& scan : scans) {
      EXPECT_EQ(scan.ranges_m.size(), points);
      EXPECT_EQ(scan.intensities.size(), points);
    }
  }
}

TEST(ScanAssembler, a_full_turn_at_the_nominal_rate_leaves_no_ray_empty) {
  ScanAssembler assembler{{}};
  Turntable table;
  for (const Scan& scan : scans_of(assembler, table, 200)) {
    for (std::size_t ray = 0; ray < scan.ranges_m.size(); ++ray)
      EXPECT_FLOAT_EQ(scan.ranges_m[ray], 1.0F) << "ray " << ray;
  }
}

TEST(ScanAssembler, the_stamp_is_the_time_of_the_beam_at_angle_zero) {
  ScanAssembler assembler{{}};
  Turntable table;
  const auto scans = scans_of(assembler, table, 150);
  ASSERT_GE(scans.size(), 2U);
  // The turntable passes 360 deg at 100.1 s, 100.2 s, ...
  EXPECT_NEAR(to_seconds(scans[0].first_beam.since_origin), 100.1, 1e-6);
  EXPECT_NEAR(to_seconds(scans[1].first_beam.since_origin), 100.2, 1e-6);
  EXPECT_NEAR(to_seconds(scans[0].turn), 0.1, 1e-6);
}

TEST(ScanAssembler, the_turn_under_way_at_the_start_is_not_a_scan) {
  ScanAssembler assembler{{}};
  Turntable table;
  table.angle_deg = 90.0;
  EXPECT_TRUE(scans_of(assembler, table, 30).empty());
  EXPECT_EQ(assembler.stats().dropped_turns, 1U);
  EXPECT_EQ(scans_of(assembler, table, 40).size(), 1U);
}

TEST(ScanAssembler, the_same_points_in_other_frames_make_the_same_scans) {
  // A law of the collection: what a turn is does not depend on where frames begin.
  Turntable a, b;
  ScanAssembler one{{}}, two{{}};
  b.angle_deg = 12 * Turntable::kStepDeg / 2;  // half a frame later
  b.time_s += 6 * Turntable::kPointS;
  const auto first = scans_of(one, a, 150), second = scans_of(two, b, 150);
  ASSERT_GE(first.size(), 2U);
  ASSERT_GE(second.size(), 2U);
  EXPECT_EQ(first[0].ranges_m, second[0].ranges_m);
  EXPECT_NEAR(to_seconds(first[0].first_beam - second[0].first_beam), 0.0, 1e-6);
}

Scan one_scan(const ScanOptions& options, int range_mm) {
  ScanAssembler assembler{options};
  Turntable table;
  table.range_m = static_cast<float>(range_mm) / 1000.0F;
  const auto scans = scans_of(assembler, table, 80);
  EXPECT_FALSE(scans.empty());
  return scans.empty() ? Scan{} : scans.front();
}

TEST(ScanAssembler, follows_rep_117_outside_its_range) {
  EXPECT_EQ(one_scan({}, 0).ranges_m[5], INFINITY) << "no echo";
  EXPECT_EQ(one_scan({}, 12001).ranges_m[5], INFINITY) << "too far";
  EXPECT_FLOAT_EQ(one_scan({}, 12000).ranges_m[5], 12.0F);
  EXPECT_FLOAT_EQ(one_scan({}, 20).ranges_m[5], 0.02F);
  EXPECT_EQ(one_scan({}, 19).ranges_m[5], -INFINITY) << "too close";
}

TEST(ScanAssembler, a_ray_without_a_measurement_is_not_a_number) {
  const Scan scan = one_scan({.points = 900}, 1000);
  int measured = 0, empty = 0;
  for (const float range : scan.ranges_m) (std::isnan(range) ? empty : measured) += 1;
  EXPECT_EQ(measured, 450);
  EXPECT_EQ(empty, 450);
}

TEST(ScanAssembler, the_nearest_point_of_a_ray_wins) {
  ScanAssembler assembler{{.points = 45}};
  Turntable table;
  std::vector<Scan> scans;
  for (int i = 0; i < 80; ++i) {
    const Sweep sweep = table.next();
    for (std::size_t p = 0; p < table.beams.size(); ++p)
      table.beams[p].range_m = p % 10 == 3 ? 0.5F : p % 10 == 4 ? 0.0F : 2.0F;
    assembler.add(sweep, table.last_beam(), [&](const Scan& scan) { scans.push_back(scan); });
  }
  ASSERT_FALSE(scans.empty());
  for (const float range : scans[0].ranges_m) EXPECT_TRUE(range == 0.5F || range == 2.0F) << range;
}

TEST(ScanAssembler, a_cropped_angle_is_not_a_number) {
  // Device angles count clockwise: 80 to 100 deg is the robot's right, ray 270 deg of the scan.
  const Scan scan = one_scan({.points = 360, .crop = true, .crop_min_deg = 80.0, .crop_max_deg = 100.0}, 1000);
  EXPECT_TRUE(std::isnan(scan.ranges_m[270]));
  EXPECT_FALSE(std::isnan(scan.ranges_m[90]));
}

TEST(ScanAssembler, an_ignored_sector_is_not_a_number_also_across_the_zero) {
  const Scan scan = one_scan({.points = 360, .ignored = {{-10.0, 5.0}, {170.0, 190.0}}}, 1000);
  for (std::size_t ray = 0; ray < 360; ++ray) {
    const bool ignored = ray >= 350 || ray <= 5 || (ray >= 170 && ray <= 190);
    EXPECT_EQ(std::isnan(scan.ranges_m[ray]), ignored) << "ray " << ray;
  }
}

TEST(ScanAssembler, an_offset_turns_the_scan_to_the_left) {
  ScanAssembler plain{{.points = 360}}, turned{{.points = 360, .offset_deg = 90.0}};
  Turntable a, b;
  const auto pierced = [](ScanAssembler& assembler, Turntable& table) {
    Scan result;
    for (int i = 0; i < 80; ++i) {
      const Sweep sweep = table.next();
      for (Beam& beam : table.beams) beam.range_m = beam.angle_deg < 30.5F ? 0.5F : 1.0F;  // near: ahead to the right
      assembler.add(sweep, table.last_beam(), [&](const Scan& scan) { result = scan; });
    }
    return result;
  };
  const Scan before = pierced(plain, a), after = pierced(turned, b);
  EXPECT_EQ(before.ranges_m[340], 0.5F);
  for (std::size_t ray = 0; ray < 360; ++ray) EXPECT_EQ(after.ranges_m[(ray + 90) % 360], before.ranges_m[ray]);
}

TEST(ScanAssembler, the_rotor_ends_a_turn_and_the_beam_chooses_the_ray) {
  // A triangulating device: light goes 7 deg less far than the rotor, so that the first beams of a turn look behind the zero.
  ScanAssembler assembler{{.points = 360}};
  Turntable table;
  std::vector<Scan> scans;
  for (int i = 0; i < 150; ++i) {
    const Sweep sweep = table.next();
    for (Beam& beam : table.beams) beam.angle_deg = std::fmod(beam.angle_deg + 353.0F, 360.0F);
    assembler.add(sweep, table.last_beam(), [&](const Scan& scan) { scans.push_back(scan); });
  }
  ASSERT_EQ(scans.size(), 2U) << "no turn is torn by beams that look back";
  EXPECT_NEAR(to_seconds(scans[1].first_beam - scans[0].first_beam), 0.1, 1e-6);
}

TEST(ScanAssembler, without_intensities_a_scan_says_so) {
  ScanAssembler assembler{{}};
  Turntable table;
  int scans = 0;
  for (int i = 0; i < 150; ++i) {
    Sweep sweep = table.next();
    sweep.has_intensities = false;
    assembler.add(sweep, table.last_beam(), [&](const Scan& scan) {
      EXPECT_FALSE(scan.has_intensities);
      ++scans;
    });
  }
  EXPECT_GT(scans, 0);
}

TEST(ScanAssembler, a_gap_of_half_a_turn_drops_the_turn) {
  ScanAssembler assembler{{}};
  Turntable table;
  scans_of(assembler, table, 50);
  const auto before = assembler.stats();
  table.time_s += 0.06;
  table.angle_deg = std::fmod(table.angle_deg + 216.0, 360.0);
  const auto scans = scans_of(assembler, table, 100);
  EXPECT_EQ(assembler.stats().dropped_turns, before.dropped_turns + 2)
      << "the torn one, and the rest up to the next zero";
  ASSERT_FALSE(scans.empty());
  for (const float range : scans[0].ranges_m) EXPECT_FLOAT_EQ(range, 1.0F);
}

/// A robot at the middle of the simulated room without range noise, through the bytes of the line.
Scan scan_of_the_room(const simulation::Room& room, const simulation::Pose& pose, bool counter_clockwise = true) {
  simulation::WorldSettings settings;
  settings.errors.range_noise_m = 0.0;
  simulation::LidarModel lidar{settings, room};
  struct Seen final : SweepSink {
    explicit Seen(bool left) : assembler{{.counter_clockwise = left}} {}
    void on_sweep(const Sweep& sweep, std::size_t) override {
      assembler.add(sweep, now, [this](const Scan& scan) { result = scan; });
    }
    ScanAssembler assembler;
    MonotonicTime now{};
    Scan result;
  } seen{counter_clockwise};
  LdProtocol protocol{4500};
  while (seen.assembler.stats().scans == 0) {
    seen.now = MonotonicTime{lidar.next_point()};
    if (const auto packet = lidar.measure(pose)) protocol.feed(print_ld06(*packet), seen);
  }
  return seen.result;
}

float toward(const Scan& scan, double direction_rad) {
  const auto rays = static_cast<double>(scan.ranges_m.size());
  const auto ray = static_cast<std::size_t>(std::lround(direction_rad / (2 * kPi) * rays) + scan.ranges_m.size());
  return scan.ranges_m[ray % scan.ranges_m.size()];
}

TEST(ScanOfARoom, a_wall_to_the_left_is_at_plus_ninety_degrees) {
  const simulation::Room wall{{{-50.0, 1.0, 50.0, 1.0}}};  // y = 1 only
  const Scan scan = scan_of_the_room(wall, {});
  EXPECT_NEAR(toward(scan, kPi / 2), 1.0, 0.002);
  EXPECT_EQ(toward(scan, -kPi / 2), INFINITY);
  EXPECT_NEAR(toward(scan, kPi / 4), std::numbers::sqrt2, 0.03);
  EXPECT_NEAR(toward(scan, 3 * kPi / 4), std::numbers::sqrt2, 0.03);
}

TEST(ScanOfARoom, keeps_the_devices_sense_if_asked) {
  const simulation::Room wall{{{-50.0, 1.0, 50.0, 1.0}}};
  const Scan scan = scan_of_the_room(wall, {}, false);
  EXPECT_NEAR(toward(scan, -kPi / 2), 1.0, 0.002);
}

TEST(ScanOfARoom, has_the_ranges_that_geometry_gives) {
  const simulation::Room room = simulation::Room::with_two_boxes();
  const simulation::Pose pose{0.3, -0.2, 0.7};
  const Scan scan = scan_of_the_room(room, pose);
  for (std::size_t ray = 0; ray < scan.ranges_m.size(); ++ray) {
    const double direction = static_cast<double>(ray) * 2 * kPi / static_cast<double>(scan.ranges_m.size());
    EXPECT_NEAR(scan.ranges_m[ray], room.range_m(pose.x_m, pose.y_m, pose.yaw_rad + direction), 0.00051)
        << "ray " << ray;
  }
}

}  // namespace
}  // namespace nacelle::lidar
