// SPDX-License-Identifier: Apache-2.0
// The law of all LiDARs: whatever the line does, every scan has the same rays, and its stamp is the time of its first beam.
#include <gtest/gtest.h>

#include <cmath>

#include "lidar/component/scan_stream.hpp"
#include "nacelle/io/scripted_stream.hpp"
#include "simulation/model/ld_lidar.hpp"
#include "simulation/model/rplidar.hpp"
#include "simulation/model/ydlidar.hpp"
#include "support/recording_host.hpp"
#include "unit/components/lidar/component/lidar_line.hpp"

namespace nacelle::lidar {
namespace {

using sensor_msgs::msg::LaserScan;

double stamp_of(const LaserScan& scan) { return scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9; }

struct Law {
  const char* model;
  std::size_t scans;
  double slow_hz, fast_hz;  ///< The motor's speed changes between these.
  BadLine::Settings line{.changed = 1e-4, .lost = 1e-4, .added = 1e-4, .longest_delay = 3ms};
  unsigned seed = 17;
  std::string scan_mode{};
};

/// Runs a device over a bad line for as long as it takes, and holds the law over all scans.
void hold_the_law(const Law& law, simulation::SerialDevice& device, simulation::LidarRotor& rotor) {
  SCOPED_TRACE(::testing::Message() << law.model << ", seed " << law.seed);
  test::RecordingContext context;
  const MonotonicTime origin = context.clock().now();
  const double wall_origin_s = 1.7e9;
  const NodeOptions node_options{context};
  LifecycleNode node{"test", node_options};
  Node talker{"talker", node_options};
  DeviceWatch watch{node, {}, {"lidar"}, origin};
  LidarOptions options;
  options.model = *find_lidar_model(law.model);
  options.port_baudrate = options.model.baud;
  options.scan_mode = law.scan_mode;
  options.scan.points = options.model.scan_points;
  options.scan.range_min_m = options.model.range_min_m;
  options.scan.range_max_m = options.model.range_max_m;
  io::ScriptedStream commands{{}};
  commands.answer_writes([&](ByteView bytes) {
    device.receive(bytes, context.clock().now() - origin);
    return Bytes{};
  });
  ScanStream stream{
      options, context.clock(), commands, talker.create_publisher<LaserScan>("scan", QoS(5)), node.get_logger(), watch};
  BadLine line{law.line, options.port_baudrate, law.seed};
  simulation::Random draws{law.seed, 5};

  stream.begin();
  stream.set_active(true);
  Duration next_speed = 5s;
  for (Duration now{}; stream.counters().published < law.scans;) {
    now += 1ms;
    ASSERT_LT(now, 20'000s) << stream.counters().line.frames << " frames of " << stream.counters().line.bytes
                            << " bytes";
    if (now >= next_speed) {
      next_speed = now + 2s + from_seconds(6.0 * draws.uniform());
      rotor.aim_at(law.slow_hz + (law.fast_hz - law.slow_hz) * draws.uniform());
    }
    device.advance(now, [&](Duration at, ByteView bytes) { line.send(at, bytes); });
    if (origin + now > context.clock().now()) context.clock().advance(origin + now - context.clock().now());
    bool came = false;
    line.deliver(now, [&](ByteView bytes, Duration received) {
      stream.on_bytes(bytes, origin + received);
      came = true;
    });
    if (!came && now % 100ms == Duration{}) stream.on_silence(origin + now);
    if (const auto ready = commands.data_terminal_ready()) device.set_data_terminal_ready(*ready);
  }

  const auto& zeros = rotor.zeros();
  const auto scans = context.published<LaserScan>("/scan");
  ASSERT_GE(scans.size(), law.scans);
  std::size_t at = 0;
  double earliest_s = 1e9, latest_s = -1e9;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const LaserScan& scan = scans[i];
    ASSERT_EQ(scan.ranges.size(), options.scan.points) << "scan " << i;
    ASSERT_TRUE(scan.intensities.empty() || scan.intensities.size() == options.scan.points);
    ASSERT_EQ(scan.angle_increment, scans[0].angle_increment);
    ASSERT_GT(scan.time_increment, 0.0F);
    const double stamp_s = stamp_of(scan) - wall_origin_s;
    while (at + 1 < zeros.size() &&
           std::abs(to_seconds(zeros[at + 1]) - stamp_s) < std::abs(to_seconds(zeros[at]) - stamp_s))
      ++at;
    const double late_s = stamp_s - to_seconds(zeros[at]);
    earliest_s = std::min(earliest_s, late_s);
    latest_s = std::max(latest_s, late_s);
    ASSERT_LT(std::abs(late_s), 0.002) << "scan " << i << " at " << stamp_s << " s";
  }
  EXPECT_LT(latest_s - earliest_s, 1e-3) << "stamps are " << earliest_s * 1e3 << " to " << latest_s * 1e3 << " ms late";
  const LidarCounters counters = stream.counters();
  EXPECT_GT(counters.line.bad_checksums, 0U) << "the line was bad";
  ::testing::Test::RecordProperty(law.model, std::to_string((latest_s - earliest_s) * 1e3) + " ms of jitter");
  std::printf("%s: %zu scans, stamps %.3f to %.3f ms late, %llu turns dropped, %llu frames, %llu bad checksums\n",
              law.model, scans.size(), earliest_s * 1e3, latest_s * 1e3,
              static_cast<unsigned long long>(counters.turns.dropped_turns),
              static_cast<unsigned long long>(counters.line.frames),
              static_cast<unsigned long long>(counters.line.bad_checksums));
}

void hold_the_law_of_ld(const Law& law) {
  const LidarModel& model = *find_lidar_model(law.model);
  simulation::LdLidar device{
      model.baud,
      {.points_per_second = static_cast<double>(model.points_per_second), .clock_error = 40e-6, .seed = law.seed},
      simulation::Room::with_two_boxes()};
  hold_the_law(law, device, device.rotor());
}

TEST(LawOfScans, an_ld06_over_a_bad_line) {
  hold_the_law_of_ld({.model = "ld06", .scans = 10'000, .slow_hz = 5.0, .fast_hz = 13.0});
}
TEST(LawOfScans, an_stl27l_over_a_bad_line) {
  hold_the_law_of_ld({.model = "stl27l", .scans = 500, .slow_hz = 5.0, .fast_hz = 13.0});
}

void hold_the_law_of_rplidar(const Law& law) {
  simulation::Rplidar::Settings settings = simulation::Rplidar::settings_of(law.model);
  settings.rotor.clock_error = 40e-6;
  settings.rotor.seed = law.seed;
  simulation::Rplidar device{settings, simulation::Room::with_two_boxes()};
  hold_the_law(law, device, device.rotor());
}

TEST(LawOfScans, an_rplidar_a1_over_a_bad_line) {
  hold_the_law_of_rplidar({.model = "rplidar_a1", .scans = 10'000, .slow_hz = 4.0, .fast_hz = 10.0});
}
TEST(LawOfScans, an_rplidar_a1_with_nodes_over_a_bad_line) {
  hold_the_law_of_rplidar(
      {.model = "rplidar_a1", .scans = 500, .slow_hz = 4.0, .fast_hz = 8.0, .scan_mode = "standard"});
}
TEST(LawOfScans, an_rplidar_a3_with_ultra_capsules_over_a_bad_line) {
  hold_the_law_of_rplidar({.model = "rplidar_a3", .scans = 300, .slow_hz = 6.0, .fast_hz = 15.0});
}
TEST(LawOfScans, an_rplidar_c1_with_dense_capsules_over_a_bad_line) {
  hold_the_law_of_rplidar({.model = "rplidar_c1", .scans = 500, .slow_hz = 8.0, .fast_hz = 12.0});
}

void hold_the_law_of_ydlidar(const Law& law, double clock_error) {
  simulation::Ydlidar::Settings settings = simulation::Ydlidar::settings_of(law.model);
  settings.rotor.clock_error = clock_error;
  settings.rotor.seed = law.seed;
  simulation::Ydlidar device{settings, simulation::Room::with_two_boxes()};
  hold_the_law(law, device, device.rotor());
}

TEST(LawOfScans, a_ydlidar_x4_over_a_bad_line) {
  hold_the_law_of_ydlidar({.model = "ydlidar_x4", .scans = 10'000, .slow_hz = 6.0, .fast_hz = 12.0}, 40e-6);
}
TEST(LawOfScans, a_ydlidar_x2_whose_rate_is_not_what_its_data_sheet_says) {
  // 2 % off. It has no clock: the rate is learnt.
  hold_the_law_of_ydlidar({.model = "ydlidar_x2", .scans = 500, .slow_hz = 5.0, .fast_hz = 8.0}, 0.02);
}
TEST(LawOfScans, a_ydlidar_g2_with_intensities_over_a_bad_line) {
  hold_the_law_of_ydlidar({.model = "ydlidar_g2", .scans = 500, .slow_hz = 6.0, .fast_hz = 12.0}, 40e-6);
}

}  // namespace
}  // namespace nacelle::lidar
