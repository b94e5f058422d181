// SPDX-License-Identifier: Apache-2.0
#include "gps/component/gps_component.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nacelle/io/pty_pair.hpp"
#include "nacelle/io/scripted_stream.hpp"
#include "simulation/protocol/nmea_receiver.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::gps {
namespace {

using geometry_msgs::msg::TwistStamped;
using sensor_msgs::msg::NavSatFix;
using sensor_msgs::msg::NavSatStatus;
using sensor_msgs::msg::TimeReference;
using test::RecordingContext;
using AtEnd = io::ScriptedStream::AtEnd;

Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }
double seconds_of(const builtin_interfaces::msg::Time& time) { return time.sec + time.nanosec * 1e-9; }

simulation::GpsReading reading_at(int second) {
  simulation::GpsReading reading;
  reading.time_of_day_ms = 45'000'000 + second * 1000;
  reading.latitude_deg = 47.285233;
  reading.longitude_deg = 8.565265;
  reading.above_geoid_m = 499.6;
  reading.geoid_m = 48.0;
  reading.speed_mps = 2.0;
  reading.course_deg = 30.0;
  return reading;
}

class GpsComponentTest : public ::testing::Test {
 protected:
  GpsComponent& make(const std::map<std::string, ParameterValue>& overrides = {}) {
    NodeOptions options{context_};
    options.parameter_overrides(overrides);
    component_ = std::make_unique<GpsComponent>(options, [this](const GpsOptions&, const Clock&) {
      auto line = std::make_unique<io::ScriptedStream>(first_, AtEnd::Blocks, [this](MonotonicTime until) {
        if (until > context_.clock().now()) context_.clock().advance(until - context_.clock().now());
      });
      line_ = line.get();
      if (is_away_) {
        line->start_away();
        line->refuse_reopen(1'000'000);
      }
      return Result<std::unique_ptr<io::ByteStream>, Problem>{std::move(line)};
    });
    return *component_;
  }
  void bring_up(GpsComponent& gps) {
    const auto configured = gps.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(gps.trigger(Transition::Activate).success);
  }
  /// A burst in three chunks, 50 ms after the moment that it is about.
  void play(const simulation::GpsReading& reading, MonotonicTime moment) {
    const std::string burst = simulation::print_nmea_burst(reading);
    const std::size_t third = burst.size() / 3;
    line_->append({moment + 50ms, bytes_of(burst.substr(0, third)), {}});
    line_->append({moment + 90ms, bytes_of(burst.substr(third, third)), {}});
    line_->append({moment + 140ms, bytes_of(burst.substr(2 * third)), {}});
  }

  RecordingContext context_;
  io::ScriptedStream* line_ = nullptr;
  std::vector<io::ScriptedStream::Step> first_{{{}, bytes_of(simulation::print_gsa({})), {}}};
  bool is_away_ = false;
  std::unique_ptr<GpsComponent> component_;
};

TEST_F(GpsComponentTest, publishes_the_fix_with_every_field_set) {
  GpsComponent& gps = make();
  bring_up(gps);
  for (int second = 0; second < 3; ++second) play(reading_at(second), MonotonicTime{2s + second * 1s});
  ASSERT_TRUE(context_.wait_for("/time_reference", 3));
  line_->wait_until_read();

  const auto fixes = context_.published<NavSatFix>("/fix");
  ASSERT_EQ(fixes.size(), 3U);
  for (const NavSatFix& fix : fixes) {
    EXPECT_EQ(fix.header.frame_id, "gps");
    EXPECT_EQ(fix.status.status, NavSatStatus::STATUS_FIX);
    EXPECT_EQ(fix.status.service, NavSatStatus::SERVICE_GPS);
    EXPECT_NEAR(fix.latitude, 47.285233, 1e-7);
    EXPECT_NEAR(fix.longitude, 8.565265, 1e-7);
    EXPECT_NEAR(fix.altitude, 547.6, 1e-9) << "above the ellipsoid";
  }
  // The first GGA came before any GST; then the receiver's estimate counts.
  EXPECT_EQ(fixes[0].position_covariance_type, NavSatFix::COVARIANCE_TYPE_APPROXIMATED);
  EXPECT_NEAR(fixes[0].position_covariance[0], std::pow(4.0 * 1.18, 2), 1e-9);
  EXPECT_NEAR(fixes[0].position_covariance[8], std::pow(4.0 * 1.54, 2), 1e-9) << "from the VDOP of the first GSA";
  EXPECT_EQ(fixes[1].position_covariance_type, NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN);
  EXPECT_NEAR(fixes[1].position_covariance[0], 1.3 * 1.3, 1e-9) << "east";
  EXPECT_NEAR(fixes[1].position_covariance[4], 1.7 * 1.7, 1e-9) << "north";
  EXPECT_NEAR(fixes[1].position_covariance[8], 2.2 * 2.2, 1e-9) << "up";
  EXPECT_EQ(fixes[1].position_covariance[1], 0.0);

  const auto velocities = context_.published<TwistStamped>("/vel");
  ASSERT_EQ(velocities.size(), 3U) << "RMC and VTG give it once";
  EXPECT_NEAR(velocities[0].twist.linear.x, 1.0, 1e-3) << "east";
  EXPECT_NEAR(velocities[0].twist.linear.y, std::sqrt(3.0), 1e-3) << "north";

  const auto times = context_.published<TimeReference>("/time_reference");
  EXPECT_EQ(times[0].source, "gps");
  EXPECT_EQ(times[0].time_ref.sec, 1735689600 + 45000) << "2025-01-01 12:30:00 UTC";
}

TEST_F(GpsComponentTest, gives_one_stamp_to_what_was_sent_about_one_moment) {
  GpsComponent& gps = make();
  bring_up(gps);
  for (int second = 0; second < 4; ++second) {
    // The thread is late once: its burst is read 60 ms after it came.
    const Duration late = second == 2 ? 60ms : 0ms;
    play(reading_at(second), MonotonicTime{2s + second * 1s + late});
  }
  ASSERT_TRUE(context_.wait_for("/fix", 4));
  line_->wait_until_read();

  const auto fixes = context_.published<NavSatFix>("/fix");
  const auto velocities = context_.published<TwistStamped>("/vel");
  ASSERT_EQ(velocities.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    // The manual wall clock is 1.7e9 s at one second; the lateness may show by a hundredth of a step.
    EXPECT_NEAR(seconds_of(fixes[i].header.stamp) - 1.7e9, 1.05 + static_cast<double>(i), 0.011) << i;
    EXPECT_EQ(fixes[i].header.stamp, velocities[i].header.stamp) << i;
  }
}

TEST_F(GpsComponentTest, without_a_fix_the_position_is_not_a_number) {
  GpsComponent& gps = make();
  bring_up(gps);
  auto reading = reading_at(0);
  reading.quality = 0;
  play(reading, MonotonicTime{2s});
  ASSERT_TRUE(context_.wait_for("/fix", 1));
  line_->wait_until_read();
  const NavSatFix fix = context_.published<NavSatFix>("/fix").front();
  EXPECT_EQ(fix.status.status, NavSatStatus::STATUS_NO_FIX);
  EXPECT_TRUE(std::isnan(fix.latitude) && std::isnan(fix.longitude) && std::isnan(fix.altitude));
  EXPECT_EQ(fix.position_covariance_type, NavSatFix::COVARIANCE_TYPE_UNKNOWN);
  EXPECT_EQ(fix.position_covariance, (std::array<double, 9>{}));
  EXPECT_TRUE(context_.published<TwistStamped>("/vel").empty());
  EXPECT_TRUE(context_.published<TimeReference>("/time_reference").empty());
  EXPECT_TRUE(context_.open_faults().empty()) << "no fix is no fault";
}

TEST_F(GpsComponentTest, takes_the_velocity_from_vtg_without_rmc) {
  GpsComponent& gps = make();
  bring_up(gps);
  const auto reading = reading_at(0);
  line_->append({MonotonicTime{2s}, bytes_of(simulation::print_gga(reading) + simulation::print_vtg(reading)), {}});
  ASSERT_TRUE(context_.wait_for("/vel", 1));
  EXPECT_NEAR(context_.published<TwistStamped>("/vel").front().twist.linear.x, 1.0, 1e-3);
}

TEST_F(GpsComponentTest, a_velocity_without_a_course_is_rest_or_nothing) {
  GpsComponent& gps = make();
  bring_up(gps);
  auto reading = reading_at(0);
  reading.course_deg.reset();
  play(reading, MonotonicTime{2s});  // 2 m/s whither?
  reading.time_of_day_ms += 1000;
  reading.speed_mps = 0.02;
  play(reading, MonotonicTime{3s});
  ASSERT_TRUE(context_.wait_for("/fix", 2));
  line_->wait_until_read();
  const auto velocities = context_.published<TwistStamped>("/vel");
  ASSERT_EQ(velocities.size(), 1U);
  EXPECT_EQ(velocities[0].twist.linear.x, 0.0);
  EXPECT_EQ(velocities[0].twist.linear.y, 0.0);
}

TEST_F(GpsComponentTest, silence_of_three_periods_is_an_open_fault_that_ends_by_itself) {
  GpsComponent& gps = make();
  bring_up(gps);
  for (int second = 0; second < 3; ++second) play(reading_at(second), MonotonicTime{2s + second * 1s});
  line_->wait_until_read();
  context_.clock().advance(2800ms);
  line_->interrupt();  // a read ends without a byte
  line_->wait_until_read();
  EXPECT_TRUE(context_.open_faults().empty());
  context_.clock().advance(101ms);
  line_->interrupt();
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_EQ(gps.get_current_state().state(), StateId::Active);

  play(reading_at(9), context_.clock().now());
  context_.wait_for_open_faults(0);
}

TEST_F(GpsComponentTest, a_fast_receiver_is_missed_sooner) {
  GpsComponent& gps = make();
  bring_up(gps);
  for (int i = 0; i < 4; ++i) {
    auto reading = reading_at(0);
    reading.time_of_day_ms += i * 200;
    play(reading, MonotonicTime{2s + i * 200ms});
  }
  line_->wait_until_read();
  context_.clock().advance(501ms);
  line_->interrupt();
  context_.wait_for_open_faults(1);
}

TEST_F(GpsComponentTest, comes_up_without_its_device_and_publishes_when_it_is_there) {
  is_away_ = true;
  GpsComponent& gps = make();
  bring_up(gps);
  ASSERT_EQ(context_.open_faults().size(), 1U);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  play(reading_at(0), MonotonicTime{2s});
  line_->refuse_reopen(0);
  ASSERT_TRUE(context_.wait_for("/fix", 1));
  context_.wait_for_open_faults(0);
}

TEST_F(GpsComponentTest, a_pulled_cable_is_an_open_fault_at_once) {
  GpsComponent& gps = make();
  bring_up(gps);
  play(reading_at(0), MonotonicTime{2s});
  line_->wait_until_read();
  line_->refuse_reopen(1'000'000);
  line_->append({{}, {}, io::StreamFault::HungUp});
  context_.wait_for_open_faults(1);
  play(reading_at(5), MonotonicTime{7s});
  line_->refuse_reopen(0);
  context_.wait_for_open_faults(0);
  EXPECT_TRUE(context_.wait_for("/fix", 2));
}

TEST_F(GpsComponentTest, only_an_active_receiver_publishes) {
  GpsComponent& gps = make();
  ASSERT_TRUE(gps.trigger(Transition::Configure).success);
  play(reading_at(0), MonotonicTime{2s});
  line_->wait_until_read();
  EXPECT_TRUE(context_.published<NavSatFix>("/fix").empty());
  ASSERT_TRUE(gps.trigger(Transition::Activate).success);
  play(reading_at(1), MonotonicTime{3s});
  line_->wait_until_read();
  EXPECT_EQ(context_.published<NavSatFix>("/fix").size(), 1U);
  ASSERT_TRUE(gps.trigger(Transition::Deactivate).success);
  ASSERT_TRUE(gps.trigger(Transition::Cleanup).success);
}

TEST_F(GpsComponentTest, configure_names_a_device_that_is_no_receiver) {
  first_ = {{{}, Bytes(100, 0x55), {}}};
  GpsComponent& gps = make({{"silence_limit", 0.02}, {"baud", std::int64_t{4800}}});
  const auto outcome = gps.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("100 bytes came in 0.0 s, but no NMEA 0183 frame"), std::string::npos)
      << outcome.reason;
  EXPECT_NE(outcome.reason.find("baud is 4800"), std::string::npos) << outcome.reason;
}

TEST_F(GpsComponentTest, counts_every_sentence_once) {
  RecordingContext context;
  LifecycleNode node{"test", NodeOptions{context}};
  DeviceWatch watch{node, {}, {"gps"}, context.clock().now()};
  GpsStream stream{{}, context.clock(), {}, node.get_logger(), watch};
  const std::string text = simulation::print_nmea_burst(reading_at(0)) +
                           "$GPGSV,3,3,12,31,22,065,,13,15,190,,12,11,343,,25,00,019,*7D\r\n$GPGGA,X*22\r\n";
  stream.on_bytes(as_bytes(text), context.clock().now());
  const GpsCounters counters = stream.counters();
  EXPECT_EQ(counters.used, 5U);
  EXPECT_EQ(counters.other, 1U);
  EXPECT_EQ(counters.malformed, 1U);
  EXPECT_EQ(counters.line.sentences, counters.used + counters.other + counters.malformed);
}

TEST(GpsStreamCost, reading_sentences_allocates_nothing) {
  RecordingContext context;
  LifecycleNode node{"test", NodeOptions{context}};
  DeviceWatch watch{node, {}, {"gps"}, context.clock().now()};
  GpsStream stream{{}, context.clock(), {}, node.get_logger(), watch};
  std::vector<std::string> bursts;
  for (int second = 0; second < 100; ++second) bursts.push_back(simulation::print_nmea_burst(reading_at(second)));
  stream.on_bytes(as_bytes(bursts[0]), context.clock().now());  // logs that there is a fix
  const test::AllocationGuard guard;
  for (const std::string& burst : bursts) stream.on_bytes(as_bytes(burst), context.clock().now());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(stream.counters().used, 505U);
}

std::string refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  GpsComponent gps{options};
  const auto outcome = gps.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(GpsParameters, what_is_wrong_is_named_with_the_way_out) {
  EXPECT_NE(refusal_of({{"port", std::string{"/dev/no_gps"}}, {"port_timeout", 0.0}, {"required_device", true}})
                .find("/dev/no_gps: no such device"),
            std::string::npos);
  EXPECT_NE(refusal_of({{"port", std::string{}}}).find("port: is empty"), std::string::npos);
  EXPECT_NE(refusal_of({{"baud", std::int64_t{12345}}}).find("12345 is not a standard baud rate"), std::string::npos);
  EXPECT_NE(refusal_of({{"frame_id", std::string{}}}).find("frame_id"), std::string::npos);
}

TEST(GpsOnTheLine, publishes_what_comes_over_a_real_terminal) {
  auto pty = io::PtyPair::create();
  ASSERT_TRUE(pty) << pty.error().what;
  const SystemClock clock;
  RecordingContext context{clock};
  NodeOptions options{context};
  options.append_parameter_override("port", pty.value()->path());
  options.append_parameter_override("silence_limit", 0.01);
  GpsComponent gps{options};
  ASSERT_TRUE(gps.trigger(Transition::Configure).success) << "nothing came yet";
  ASSERT_TRUE(gps.trigger(Transition::Activate).success);
  const std::string burst = simulation::print_nmea_burst(reading_at(0));
  EXPECT_EQ(pty.value()->write_some(as_bytes(burst)), burst.size());
  ASSERT_TRUE(context.wait_for("/fix", 1, 30s));
  EXPECT_NEAR(context.published<NavSatFix>("/fix").front().latitude, 47.285233, 1e-7);
  ASSERT_TRUE(gps.trigger(Transition::Deactivate).success);
}

}  // namespace
}  // namespace nacelle::gps
