// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_component.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <thread>

#include "nacelle/io/scripted_stream.hpp"
#include "nacelle/io/serial_port.hpp"
#include "simulation/component/run_device.hpp"
#include "simulation/model/rplidar.hpp"
#include "simulation/model/sensor_models.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"
#include "unit/components/simulation/running_world.hpp"

namespace nacelle::lidar {
namespace {

using sensor_msgs::msg::LaserScan;
using test::RecordingContext;
using AtEnd = io::ScriptedStream::AtEnd;

double seconds_of(const LaserScan& scan) { return scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9; }

/// The LiDAR of the simulated robot as a script: packets with the times at which their last byte arrives.
class ScriptedLidar {
 public:
  io::ScriptedStream::Step packet() {
    for (;;) {
      const Duration measured = lidar_.next_point();
      if (const auto packet = lidar_.measure({})) {
        const auto bytes = print_ld06(*packet);
        return {start_ + measured + 47 * io::byte_time(230400), Bytes(bytes.begin(), bytes.end()), {}};
      }
    }
  }
  void play(io::ScriptedStream& line, int packets) {
    for (int i = 0; i < packets; ++i) line.append(packet());
  }

 private:
  const MonotonicTime start_{1s};  // where the manual clock begins
  const simulation::Room room_ = simulation::Room::with_two_boxes();
  simulation::LidarModel lidar_{{.seed = 1}, room_};
};

class LidarComponentTest : public ::testing::Test {
 protected:
  /// Makes a component over a scripted line whose reads move the manual clock.
  LidarComponent& make(AtEnd at_end = AtEnd::Blocks, const std::map<std::string, ParameterValue>& overrides = {}) {
    NodeOptions options{context_};
    options.parameter_overrides(overrides);
    component_ = std::make_unique<LidarComponent>(options, [this, at_end](const LidarOptions&, const Clock&) {
      std::vector<io::ScriptedStream::Step> script;
      if (first_packet_) script.push_back(lidar_.packet());
      if (!noise_.empty()) script.push_back({{}, noise_, {}});
      auto line = std::make_unique<io::ScriptedStream>(std::move(script), at_end, [this](MonotonicTime until) {
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
  void bring_up(LidarComponent& lidar) {
    const auto configured = lidar.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(lidar.trigger(Transition::Activate).success);
  }
  FaultReason wait_for_fault() {
    while (context_.faults().empty()) std::this_thread::yield();
    return context_.faults().front();
  }

  RecordingContext context_;
  ScriptedLidar lidar_;
  io::ScriptedStream* line_ = nullptr;
  bool first_packet_ = true;
  bool is_away_ = false;
  Bytes noise_;
  std::unique_ptr<LidarComponent> component_;
};

TEST_F(LidarComponentTest, publishes_full_turns_with_every_field_set) {
  LidarComponent& lidar = make();
  bring_up(lidar);
  lidar_.play(*line_, 150);  // four turns: the first begins with the first packet, which is not a whole turn by then
  ASSERT_TRUE(context_.wait_for("/scan", 2));

  for (const LaserScan& scan : context_.published<LaserScan>("/scan")) {
    EXPECT_EQ(scan.header.frame_id, "lidar_link");
    EXPECT_EQ(scan.ranges.size(), 450U);
    EXPECT_EQ(scan.intensities.size(), 450U);
    EXPECT_EQ(scan.angle_min, 0.0F);
    EXPECT_NEAR(scan.angle_increment, 2 * std::numbers::pi / 450, 1e-7);
    EXPECT_NEAR(scan.angle_max, 449 * 2 * std::numbers::pi / 450, 1e-5);
    EXPECT_NEAR(scan.scan_time, 0.1, 1e-4);
    EXPECT_NEAR(scan.time_increment, 0.1 / 450, 1e-6);
    EXPECT_FLOAT_EQ(scan.range_min, 0.02F);
    EXPECT_FLOAT_EQ(scan.range_max, 12.0F);
    EXPECT_NEAR(scan.ranges[0], 2.0, 0.05) << "the wall in front";
    EXPECT_NEAR(scan.ranges[112], 2.0, 0.05) << "the wall to the left";
    EXPECT_GT(scan.intensities[0], 0.0F);
  }
}

TEST_F(LidarComponentTest, stamps_a_scan_with_the_time_of_its_first_beam) {
  LidarComponent& lidar = make();
  bring_up(lidar);
  lidar_.play(*line_, 200);
  ASSERT_TRUE(context_.wait_for("/scan", 3));

  // The world's turn k begins at k * 0.1 s; the manual wall clock starts at 1.7e9 s with it.
  const auto scans = context_.published<LaserScan>("/scan");
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_NEAR(seconds_of(scans[i]) - 1.7e9, 0.1 * static_cast<double>(i + 1), 2e-6) << "scan " << i;
  }
}

TEST_F(LidarComponentTest, only_an_active_lidar_publishes) {
  LidarComponent& lidar = make();
  ASSERT_TRUE(lidar.trigger(Transition::Configure).success);
  lidar_.play(*line_, 150);
  line_->wait_until_read();
  EXPECT_TRUE(context_.published<LaserScan>("/scan").empty()) << "configured";

  ASSERT_TRUE(lidar.trigger(Transition::Activate).success);
  lidar_.play(*line_, 150);
  line_->wait_until_read();
  const std::size_t published = context_.published<LaserScan>("/scan").size();
  EXPECT_GE(published, 3U);

  ASSERT_TRUE(lidar.trigger(Transition::Deactivate).success);
  lidar_.play(*line_, 150);
  line_->wait_until_read();
  EXPECT_EQ(context_.published<LaserScan>("/scan").size(), published) << "deactivated";
}

TEST_F(LidarComponentTest, silence_is_an_open_fault_of_a_lidar_that_stays_active_and_ends_by_itself) {
  LidarComponent& lidar = make();
  bring_up(lidar);
  lidar_.play(*line_, 150);
  line_->wait_until_read();
  const std::size_t before = context_.published<LaserScan>("/scan").size();
  context_.clock().advance(401ms);
  line_->interrupt();  // the read ends without a byte
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_NE(context_.open_faults()[0].text.find("/dev/ttyUSB0: silent for 0.4 s"), std::string::npos);
  EXPECT_EQ(lidar.get_current_state().state(), StateId::Active);

  lidar_.play(*line_, 150);
  context_.wait_for_open_faults(0);
  line_->wait_until_read();
  EXPECT_GT(context_.published<LaserScan>("/scan").size(), before);
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(LidarComponentTest, comes_up_without_its_device_and_publishes_when_it_is_there) {
  is_away_ = true;
  LidarComponent& lidar = make();
  bring_up(lidar);
  ASSERT_EQ(context_.open_faults().size(), 1U) << "the fault is reported before the bring-up continues";
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);

  lidar_.play(*line_, 150);
  line_->refuse_reopen(0);
  ASSERT_TRUE(context_.wait_for("/scan", 2));
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(LidarComponentTest, with_device_lost_fault_silence_is_reported_once) {
  LidarComponent& lidar = make(AtEnd::Silence, {{"silence_limit", 0.5}, {"device_lost", std::string{"fault"}}});
  bring_up(lidar);
  const FaultReason fault = wait_for_fault();
  EXPECT_EQ(fault.code, "LIDAR_SILENT");
  EXPECT_NE(fault.text.find("/dev/ttyUSB0"), std::string::npos) << fault.text;
  EXPECT_EQ(lidar.process_fault(fault).state, StateId::Unconfigured);
  EXPECT_EQ(context_.faults().size(), 1U);
}

TEST_F(LidarComponentTest, a_cable_that_comes_back_soon_is_no_fault) {
  LidarComponent& lidar = make();
  bring_up(lidar);
  lidar_.play(*line_, 80);
  line_->append({{}, {}, io::StreamFault::HungUp});
  lidar_.play(*line_, 150);
  line_->wait_until_read();
  EXPECT_TRUE(context_.faults().empty());
  EXPECT_GE(context_.published<LaserScan>("/scan").size(), 4U);
}

TEST_F(LidarComponentTest, with_device_lost_fault_a_cable_that_stays_away_is_a_fault) {
  LidarComponent& lidar = make(AtEnd::HangsUp, {{"silence_limit", 0.01}, {"device_lost", std::string{"fault"}}});
  first_packet_ = true;
  ASSERT_TRUE(lidar.trigger(Transition::Configure).success);
  line_->refuse_reopen(1'000'000);
  context_.clock().advance(1s);
  EXPECT_EQ(wait_for_fault().code, "LIDAR_SILENT");
}

TEST_F(LidarComponentTest, a_required_device_that_says_nothing_fails_the_configuration) {
  first_packet_ = false;
  LidarComponent& lidar = make(AtEnd::Blocks, {{"silence_limit", 0.02}, {"required_device", true}});
  const auto outcome = lidar.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.state, StateId::Unconfigured);
  EXPECT_NE(outcome.reason.find("nothing came in 0.0 s"), std::string::npos) << outcome.reason;
}

TEST_F(LidarComponentTest, configure_names_a_device_that_is_no_lidar) {
  first_packet_ = false;
  noise_ = Bytes(100, 0x55);
  LidarComponent& lidar = make(AtEnd::Blocks, {{"silence_limit", 0.02}, {"port_baudrate", std::int64_t{115200}}});
  const auto outcome = lidar.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("100 bytes came in 0.4 s, but no ld06 frame"), std::string::npos) << outcome.reason;
  EXPECT_NE(outcome.reason.find("230400"), std::string::npos) << outcome.reason;
}

TEST_F(LidarComponentTest, configure_names_the_device_that_is_there_instead) {
  first_packet_ = false;
  const Bytes frame{0x55, 0x51, 0, 0, 0, 0, 0, 0, 0, 0, 0xA6};  // of a WT901: its accelerometer reads zero
  for (int i = 0; i < 5; ++i) noise_.insert(noise_.end(), frame.begin(), frame.end());
  LidarComponent& lidar = make(AtEnd::Blocks, {{"silence_limit", 0.02}});
  const auto outcome = lidar.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("but no ld06 frame: they come from a WT901 IMU"), std::string::npos) << outcome.reason;
}

TEST_F(LidarComponentTest, can_be_cleaned_up_and_configured_again) {
  LidarComponent& lidar = make();
  for (int round = 0; round < 3; ++round) {
    bring_up(lidar);
    ASSERT_TRUE(lidar.trigger(Transition::Deactivate).success);
    ASSERT_TRUE(lidar.trigger(Transition::Cleanup).success);
  }
  ASSERT_TRUE(lidar.trigger(Transition::Shutdown).success);
}

std::string refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  LidarComponent lidar{options};
  const auto outcome = lidar.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(LidarParameters, what_is_wrong_is_named_with_the_way_out) {
  EXPECT_NE(refusal_of({{"port_name", std::string{"/dev/no_lidar"}}, {"port_timeout", 0.0}, {"required_device", true}})
                .find("/dev/no_lidar: no such device"),
            std::string::npos);
  EXPECT_NE(refusal_of({{"port_name", std::string{}}}).find("port_name: is empty"), std::string::npos);
  EXPECT_NE(refusal_of({{"port_baudrate", std::int64_t{12345}}}).find("12345 is not a standard baud rate"),
            std::string::npos);
  EXPECT_NE(refusal_of({{"product_name", std::string{"LDLiDAR_LD60"}}}).find("LDLiDAR_LD06"), std::string::npos);
  EXPECT_NE(refusal_of({{"range_min", 13.0}}).find("range_max"), std::string::npos);
  EXPECT_NE(refusal_of({{"frame_id", std::string{}}}).find("frame_id"), std::string::npos);
}

TEST(LidarParameters, the_model_gives_the_defaults) {
  RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("model", std::string{"stl27l"});
  options.append_parameter_override("range_max", 20.0);
  const LidarComponent lidar{options};
  const auto read = read_lidar_parameters(lidar);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->port_baudrate, 921600U);
  EXPECT_EQ(read->scan.points, 2160U);
  EXPECT_EQ(read->scan.range_min_m, 0.03);
  EXPECT_EQ(read->scan.range_max_m, 20.0) << "what is given counts";
}

TEST(LidarParameters, the_makers_product_name_is_a_model) {
  RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("product_name", std::string{"LDLiDAR_STL27L"});
  const auto read = read_lidar_parameters(LidarComponent{options});
  ASSERT_TRUE(read);
  EXPECT_EQ(read->model.name, "stl27l");
  EXPECT_NE(refusal_of({{"model", std::string{"ld19"}}, {"product_name", std::string{"LDLiDAR_STL27L"}}})
                .find("is not the model ld19"),
            std::string::npos);
  EXPECT_NE(refusal_of({{"model", std::string{"ld20"}}}).find("stl27l"), std::string::npos) << "all models are named";
}

TEST(LidarParameters, sectors_to_ignore_are_pairs_of_angles) {
  RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("ignore_array", std::string{"-10, 10,170.5,190"});
  const auto read = read_lidar_parameters(LidarComponent{options});
  ASSERT_TRUE(read);
  ASSERT_EQ(read->scan.ignored.size(), 2U);
  EXPECT_EQ(read->scan.ignored[0].from_deg, -10.0);
  EXPECT_EQ(read->scan.ignored[1].from_deg, 170.5);
  for (const char* wrong : {"10", "10,20,30", "20,10", "a,b", "10;20", "1e9,2e9", "10,,20"})
    EXPECT_NE(refusal_of({{"ignore_array", std::string{wrong}}}).find("pairs of angles"), std::string::npos) << wrong;
}

TEST(LidarParameters, the_topic_can_be_named) {
  RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("topic_name", std::string{"front/scan"});
  const LidarComponent lidar{options};
  EXPECT_EQ(lidar.get_name(), "lidar");
  EXPECT_FALSE(context.wait_for("/scan", 0, 0ms)) << "the default topic has no publisher";
  EXPECT_TRUE(context.wait_for("/front/scan", 0, 0ms));
}

TEST(ScanStream, decoding_and_assembling_allocate_nothing) {
  RecordingContext context;
  const NodeOptions options{context};
  LifecycleNode node{"test", options};
  DeviceWatch watch{node, {}, {"lidar"}, context.clock().now()};
  io::ScriptedStream line{{}};
  ScanStream stream{{},   context.clock(), line, node.create_publisher<LaserScan>("scan", QoS(5)), node.get_logger(),
                    watch};
  ScriptedLidar lidar;
  std::vector<Bytes> packets;
  for (int i = 0; i < 400; ++i) packets.push_back(lidar.packet().bytes);
  const test::AllocationGuard guard;
  for (const Bytes& packet : packets) stream.on_bytes(packet, context.clock().now());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GE(stream.counters().line.frames, 400U);
}

TEST(LidarOnTheLine, shows_the_simulated_room_through_a_real_terminal) {
  simulation::RunningWorld world{"lidar_component"};
  RecordingContext context{world.clock()};
  NodeOptions options{context};
  options.append_parameter_override("port_name", world.path("lidar"));
  LidarComponent lidar{options};
  const auto configured = lidar.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  ASSERT_TRUE(lidar.trigger(Transition::Activate).success);
  ASSERT_TRUE(context.wait_for("/scan", 2, 30s));

  const auto scans = context.published<LaserScan>("/scan");
  const auto room = simulation::Room::with_two_boxes();
  const LaserScan& scan = scans.back();
  int far_off = 0;
  for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
    const double expected = room.range_m(0.0, 0.0, static_cast<double>(ray) * 2 * std::numbers::pi / 450);
    if (std::abs(static_cast<double>(scan.ranges[ray]) - expected) > 0.06) ++far_off;  // six standard deviations
  }
  EXPECT_LE(far_off, 8) << "rays that graze a box's corner may differ";
  EXPECT_NEAR(seconds_of(scans[1]) - seconds_of(scans[0]), 0.1, 0.02);
  ASSERT_TRUE(lidar.trigger(Transition::Deactivate).success);
  EXPECT_TRUE(context.faults().empty());
}

/// A simulated device on a thread of this process, behind a real pty.
class RunningDevice {
 public:
  explicit RunningDevice(const std::string& name)
      : link_(::testing::TempDir() + "device_" + std::to_string(getpid()) + "_" + name) {
    thread_ = std::thread{[this, name] {
      const auto done = simulation::run_device({.name = name, .link = link_, .stop_descriptor = stop_.descriptor()},
                                               clock_, [this](const std::string&) { ready_.store(true); });
      EXPECT_TRUE(done) << done.error().what;
      ready_.store(true);
    }};
    while (!ready_.load()) std::this_thread::yield();
  }
  RunningDevice(const RunningDevice&) = delete;
  RunningDevice& operator=(const RunningDevice&) = delete;
  ~RunningDevice() {
    stop_.ring();
    thread_.join();
  }
  [[nodiscard]] const std::string& link() const { return link_; }
  [[nodiscard]] const SystemClock& clock() const { return clock_; }

 private:
  SystemClock clock_;
  const std::string link_;
  Bell stop_;
  std::atomic<bool> ready_{false};
  std::thread thread_;
};

TEST(LidarOnTheLine, each_family_is_started_and_stopped_through_a_real_terminal) {
  for (const char* model : {"rplidar_c1", "ydlidar_x4", "stl27l"}) {
    RunningDevice device{model};
    RecordingContext context{device.clock()};
    NodeOptions options{context};
    options.append_parameter_override("model", std::string{model});
    options.append_parameter_override("port_name", device.link());
    LidarComponent lidar{options};
    for (int round = 1; round <= 2; ++round) {
      const auto configured = lidar.trigger(Transition::Configure);
      ASSERT_TRUE(configured.success) << model << ": " << configured.reason;
      ASSERT_TRUE(lidar.trigger(Transition::Activate).success) << model;
      const std::size_t before = context.published<LaserScan>("/scan").size();
      ASSERT_TRUE(context.wait_for("/scan", before + 2, 30s)) << model;
      ASSERT_TRUE(lidar.trigger(Transition::Deactivate).success) << model;
      ASSERT_TRUE(lidar.trigger(Transition::Cleanup).success) << model;
    }
    EXPECT_EQ(context.published<LaserScan>("/scan").back().ranges.size(), find_lidar_model(model)->scan_points);
    EXPECT_TRUE(context.faults().empty()) << model;
  }
}

/// A component whose line answers as a simulated RPLIDAR A1 does; time runs as fast as the line is read.
class CommandedLidarTest : public ::testing::Test {
 protected:
  CommandedLidarTest() {
    NodeOptions options{context_};
    options.append_parameter_override("model", std::string{"rplidar_a1"});
    component_ = std::make_unique<LidarComponent>(options, [this](const LidarOptions&, const Clock&) {
      auto line = std::make_unique<io::ScriptedStream>(std::vector<io::ScriptedStream::Step>{}, AtEnd::Silence,
                                                       [this](MonotonicTime until) {
                                                         if (until > context_.clock().now())
                                                           context_.clock().advance(until - context_.clock().now());
                                                       });
      line->answer_writes([this](ByteView bytes) {
        Bytes answer;
        const Duration now = context_.clock().now().since_origin;
        device_.receive(bytes, now);
        // What it measures meanwhile does not matter here, only what it answers.
        device_.advance(Duration{},
                        [&](Duration, ByteView sent) { answer.insert(answer.end(), sent.begin(), sent.end()); });
        return answer;
      });
      line_ = line.get();
      return Result<std::unique_ptr<io::ByteStream>, Problem>{std::move(line)};
    });
  }
  RecordingContext context_;
  simulation::Rplidar device_{simulation::Rplidar::settings_of("rplidar_a1"), simulation::Room::with_two_boxes()};
  io::ScriptedStream* line_ = nullptr;
  std::unique_ptr<LidarComponent> component_;
};

TEST_F(CommandedLidarTest, configure_identifies_and_deactivate_stops_stream_and_motor) {
  const auto configured = component_->trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  EXPECT_FALSE(device_.is_scanning()) << "configured";
  EXPECT_EQ(line_->data_terminal_ready(), true) << "the A1's motor stands while DTR is set";

  ASSERT_TRUE(component_->trigger(Transition::Activate).success);
  while (line_->data_terminal_ready() != false) std::this_thread::yield();
  ASSERT_TRUE(component_->trigger(Transition::Deactivate).success);
  EXPECT_EQ(line_->data_terminal_ready(), true) << "deactivated";
  const Bytes written = line_->written();
  ASSERT_GE(written.size(), 2U);
  EXPECT_EQ((Bytes{written.end() - 2, written.end()}), (Bytes{0xA5, 0x25})) << "the last word is the stop";
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(CommandedLidarTest, a_shutdown_stops_a_running_device) {
  ASSERT_TRUE(component_->trigger(Transition::Configure).success);
  ASSERT_TRUE(component_->trigger(Transition::Activate).success);
  while (line_->data_terminal_ready() != false) std::this_thread::yield();
  Bytes written;
  line_->answer_writes([&](ByteView bytes) {
    written.insert(written.end(), bytes.begin(), bytes.end());
    return Bytes{};
  });
  ASSERT_TRUE(component_->trigger(Transition::Shutdown).success);
  ASSERT_GE(written.size(), 2U);
  EXPECT_EQ((Bytes{written.end() - 2, written.end()}), (Bytes{0xA5, 0x25}));
}

TEST_F(CommandedLidarTest, a_device_that_protects_itself_fails_the_configuration_with_its_code) {
  device_.set_health(2, 0x8001, false);
  const auto configured = component_->trigger(Transition::Configure);
  EXPECT_FALSE(configured.success);
  EXPECT_NE(configured.reason.find("health is error, code 32769"), std::string::npos) << configured.reason;
}

}  // namespace
}  // namespace nacelle::lidar
