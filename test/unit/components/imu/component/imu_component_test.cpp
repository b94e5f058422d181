// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_component.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <thread>

#include "imu/model/wt901_reader.hpp"
#include "nacelle/io/scripted_stream.hpp"
#include "nacelle/io/serial_port.hpp"
#include "simulation/model/sensor_models.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"
#include "unit/components/simulation/running_world.hpp"

namespace nacelle::imu {
namespace {

using sensor_msgs::msg::Imu;
using sensor_msgs::msg::MagneticField;
using test::RecordingContext;
using AtEnd = io::ScriptedStream::AtEnd;

constexpr double kDeg = std::numbers::pi / 180.0;

template <typename Message>
double seconds_of(const Message& message) {
  return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9;
}

/// A WT901 at 100 Hz as a script: whole samples of five frames, with the times at which their last byte arrives.
class ScriptedImu {
 public:
  io::ScriptedStream::Step sample(const simulation::Wt901Reading& reading) {
    Bytes bytes;
    for (const std::uint8_t type : {0x51, 0x52, 0x53, 0x54, 0x59}) {
      const auto frame = print_wt901(type, reading);
      bytes.insert(bytes.end(), frame.begin(), frame.end());
    }
    next_ += 10ms;
    return {next_ - 10ms + 55 * io::byte_time(115200), bytes, {}};
  }
  static simulation::Wt901Reading at_rest(double yaw_rate_dps = 0.0) {
    simulation::Wt901Reading reading;
    reading.acceleration_g = {0.0, 0.0, 1.0};
    reading.angular_velocity_dps = {0.0, 0.0, yaw_rate_dps};
    reading.magnetic_field_counts = {0.0, 133.0, -287.0};
    return reading;
  }

 private:
  MonotonicTime next_{1s};  // where the manual clock begins
};

class ImuComponentTest : public ::testing::Test {
 protected:
  /// Makes a component over a scripted line; `script` is there before configure.
  ImuComponent& make(int samples, double yaw_rate_dps = 0.0, std::map<std::string, ParameterValue> overrides = {},
                     AtEnd at_end = AtEnd::Blocks) {
    overrides.emplace("command_pause", 0.0);
    overrides.emplace("calibration_samples", std::int64_t{20});
    NodeOptions options{context_};
    options.parameter_overrides(overrides);
    const auto open = [=, this](const ImuOptions&, const Clock&) {
      std::vector<io::ScriptedStream::Step> script;
      script.reserve(static_cast<std::size_t>(samples));
      for (int i = 0; i < samples; ++i) script.push_back(imu_.sample(ScriptedImu::at_rest(yaw_rate_dps)));
      auto line = std::make_unique<io::ScriptedStream>(std::move(script), at_end, [this](MonotonicTime until) {
        if (until > context_.clock().now()) context_.clock().advance(until - context_.clock().now());
      });
      line_ = line.get();
      if (is_away_) {
        line->start_away();
        line->refuse_reopen(1'000'000);
      }
      return Result<std::unique_ptr<io::ByteStream>, Problem>{std::move(line)};
    };
    component_ = std::make_unique<ImuComponent>(options, ImuPorts{open, {}});
    return *component_;
  }
  void play(int samples, double yaw_rate_dps = 0.0) {
    for (int i = 0; i < samples; ++i) line_->append(imu_.sample(ScriptedImu::at_rest(yaw_rate_dps)));
    line_->wait_until_read();
  }

  RecordingContext context_;
  ScriptedImu imu_;
  io::ScriptedStream* line_ = nullptr;
  bool is_away_ = false;
  std::unique_ptr<ImuComponent> component_;
};

TEST_F(ImuComponentTest, publishes_three_messages_of_each_sample_with_one_stamp) {
  ImuComponent& imu = make(25);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  const std::size_t before = context_.published<Imu>("/imu/data").size();
  play(10);

  const auto raw = context_.published<Imu>("/imu/data_raw");
  const auto oriented = context_.published<Imu>("/imu/data");
  const auto field = context_.published<MagneticField>("/imu/mag");
  ASSERT_EQ(raw.size(), before + 10);
  ASSERT_EQ(oriented.size(), raw.size());
  ASSERT_EQ(field.size(), raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    EXPECT_EQ(raw[i].header.stamp.nanosec, oriented[i].header.stamp.nanosec);
    EXPECT_EQ(raw[i].header.stamp.nanosec, field[i].header.stamp.nanosec);
    EXPECT_EQ(raw[i].header.frame_id, "imu_link");
  }
}

TEST_F(ImuComponentTest, stamps_a_sample_with_the_time_its_first_byte_was_sent) {
  ImuComponent& imu = make(25);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  play(10);
  const auto messages = context_.published<Imu>("/imu/data");
  ASSERT_GE(messages.size(), 10U);
  // The script's sample n is taken at n * 10 ms; the manual wall clock starts at 1.7e9 s with it.
  for (std::size_t i = 0; i < 10; ++i) {
    const double expected = 0.01 * static_cast<double>(25 + i);
    EXPECT_NEAR(seconds_of(messages[messages.size() - 10 + i]) - 1.7e9, expected, 1e-6) << "sample " << i;
  }
}

TEST_F(ImuComponentTest, stamps_what_came_while_its_thread_was_away_when_it_was_measured) {
  ImuComponent& imu = make(25);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  auto burst = imu_.sample(ScriptedImu::at_rest());
  for (int i = 1; i < 50; ++i) {
    const auto next = imu_.sample(ScriptedImu::at_rest());
    burst.at = next.at;
    burst.bytes.insert(burst.bytes.end(), next.bytes.begin(), next.bytes.end());
  }
  line_->append(burst);
  line_->wait_until_read();
  const auto messages = context_.published<Imu>("/imu/data");
  ASSERT_GE(messages.size(), 50U);
  for (std::size_t i = 0; i < 50; ++i) {
    const double expected = 0.01 * static_cast<double>(25 + i);
    EXPECT_NEAR(seconds_of(messages[messages.size() - 50 + i]) - 1.7e9, expected, 0.0021) << "sample " << i;
  }
}

TEST_F(ImuComponentTest, covariances_are_never_zero_for_what_is_there_and_minus_one_for_what_is_not) {
  ImuComponent& imu = make(25);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  play(1);
  const Imu raw = context_.published<Imu>("/imu/data_raw").back();
  const Imu oriented = context_.published<Imu>("/imu/data").back();
  const MagneticField field = context_.published<MagneticField>("/imu/mag").back();
  EXPECT_EQ(raw.orientation_covariance[0], -1.0);
  EXPECT_NEAR(oriented.orientation_covariance[0], 0.05 * 0.05, 1e-12);
  for (const std::size_t i : {0U, 4U, 8U}) {
    EXPECT_NEAR(raw.angular_velocity_covariance[i], 0.002 * 0.002, 1e-15);
    EXPECT_NEAR(raw.linear_acceleration_covariance[i], 0.04 * 0.04, 1e-12);
    EXPECT_NEAR(oriented.orientation_covariance[i], 0.05 * 0.05, 1e-12);
    EXPECT_NEAR(field.magnetic_field_covariance[i], 25e-14, 1e-18);
  }
  EXPECT_NEAR(oriented.orientation.w, 1.0, 1e-9);
  EXPECT_NEAR(oriented.linear_acceleration.z, 9.80665, 1e-9);
  EXPECT_NEAR(field.magnetic_field.y, 133 * 1.5e-7, 1e-12);
}

TEST_F(ImuComponentTest, takes_the_bias_off_that_it_measured_at_rest) {
  ImuComponent& imu = make(25, 0.5);  // 0.5 deg/s while standing
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  play(1, 10.5);
  EXPECT_NEAR(context_.published<Imu>("/imu/data").back().angular_velocity.z, 10.0 * kDeg, 0.07 * kDeg);
  EXPECT_NEAR(context_.published<Imu>("/imu/data_raw").back().angular_velocity.z, 10.0 * kDeg, 0.07 * kDeg);
}

TEST_F(ImuComponentTest, refuses_to_activate_while_the_robot_turns_and_can_be_asked_again) {
  ImuComponent& imu = make(25, 30.0, {{"silence_limit", 0.1}});
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  const auto refused = imu.trigger(Transition::Activate);
  EXPECT_FALSE(refused.success);
  EXPECT_EQ(refused.state, StateId::Inactive);
  EXPECT_NE(refused.reason.find("the robot turns"), std::string::npos) << refused.reason;
  EXPECT_NE(refused.reason.find("keep the robot still"), std::string::npos) << refused.reason;
  // 30 deg/s are 0.524 rad/s; the device's unit is 2000/32768 deg/s.
  EXPECT_NE(refused.reason.find("gyro (0.000 0.000 0.524) rad/s"), std::string::npos) << refused.reason;
  EXPECT_NE(refused.reason.find("accelerometer (0.000 0.000 9.807) m/s^2"), std::string::npos) << refused.reason;

  play(60);  // the first of them spoil one calibration
  const auto accepted = imu.trigger(Transition::Activate);
  EXPECT_TRUE(accepted.success) << accepted.reason;
}

TEST_F(ImuComponentTest, skips_calibration_if_it_is_disabled) {
  ImuComponent& imu = make(3, 30.0, {{"calibrate_gyro", false}});
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  play(1, 30.0);
  EXPECT_NEAR(context_.published<Imu>("/imu/data").back().angular_velocity.z, 30.0 * kDeg, 0.07 * kDeg);
}

TEST_F(ImuComponentTest, sets_the_device_up) {
  ImuComponent& imu = make(3, 0.0, {{"rate", 50.0}});
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  simulation::Wt901Registers device;
  device.feed(line_->written(), 0.0);
  EXPECT_EQ(device.rate_hz(), 50.0);
  EXPECT_EQ(device.mask(), 0x021E);
  EXPECT_EQ(device.stats().commands, 3U);
  EXPECT_EQ(device.stats().skipped_bytes, 0U);
}

TEST_F(ImuComponentTest, leaves_the_device_unconfigured_if_set_up_is_disabled) {
  ImuComponent& imu = make(3, 0.0, {{"configure_device", false}});
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  EXPECT_TRUE(line_->written().empty());
}

TEST_F(ImuComponentTest, a_cable_that_comes_back_is_an_open_fault_meanwhile_and_the_device_is_set_up_anew) {
  ImuComponent& imu = make(25);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  const std::size_t commands = line_->written().size();
  const std::size_t before = context_.published<Imu>("/imu/data").size();
  line_->refuse_reopen(1'000'000);
  line_->append({{}, {}, io::StreamFault::HungUp});
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_EQ(imu.get_current_state().state(), StateId::Active);

  line_->refuse_reopen(0);
  play(10);
  EXPECT_TRUE(context_.open_faults().empty());
  EXPECT_TRUE(context_.faults().empty());
  EXPECT_EQ(context_.published<Imu>("/imu/data").size(), before + 10);
  EXPECT_EQ(line_->written().size(), 2 * commands);
}

TEST_F(ImuComponentTest, a_silent_device_is_set_up_again_since_its_power_may_have_gone) {
  ImuComponent& imu = make(25);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  line_->wait_until_read();
  const std::size_t commands = line_->written().size();
  context_.clock().advance(401ms);
  line_->interrupt();
  context_.wait_for_open_faults(1);
  line_->wait_until_read();
  EXPECT_EQ(line_->written().size(), 2 * commands);
}

TEST_F(ImuComponentTest, one_that_comes_after_the_activation_is_calibrated_before_it_publishes) {
  is_away_ = true;
  ImuComponent& imu = make(0);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  ASSERT_EQ(context_.open_faults().size(), 1U);

  line_->refuse_reopen(0);
  play(19, 0.5);
  EXPECT_TRUE(context_.published<Imu>("/imu/data").empty()) << "not calibrated yet";
  EXPECT_EQ(context_.open_faults().size(), 1U);
  play(6, 0.5);
  EXPECT_TRUE(context_.open_faults().empty());
  ASSERT_FALSE(context_.published<Imu>("/imu/data").empty());
  EXPECT_NEAR(context_.published<Imu>("/imu/data").back().angular_velocity.z, 0.0, 0.07 * kDeg);
}

TEST_F(ImuComponentTest, with_device_lost_fault_silence_is_a_fault) {
  ImuComponent& imu = make(25, 0.0, {{"device_lost", std::string{"fault"}}}, AtEnd::Silence);
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  while (context_.faults().empty()) std::this_thread::yield();
  EXPECT_EQ(context_.faults().front().code, "IMU_SILENT");
  EXPECT_EQ(imu.process_fault(context_.faults().front()).state, StateId::Unconfigured);
}

TEST_F(ImuComponentTest, a_required_device_that_says_nothing_fails_the_configuration) {
  ImuComponent& imu = make(0, 0.0, {{"silence_limit", 0.02}, {"required_device", true}});
  const auto outcome = imu.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("nothing came"), std::string::npos) << outcome.reason;
}

std::string refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  ImuComponent imu{options};
  const auto outcome = imu.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(ImuParameters, what_is_wrong_is_named_with_the_way_out) {
  EXPECT_NE(refusal_of({{"port", std::string{"/dev/no_imu"}}, {"port_timeout", 0.0}, {"required_device", true}})
                .find("/dev/no_imu: no such device"),
            std::string::npos);
  EXPECT_NE(refusal_of({{"rate", 60.0}}).find("no rate of 60 Hz"), std::string::npos);
  EXPECT_NE(refusal_of({{"baudrate", std::int64_t{9600}}}).find("need more than 9600 baud"), std::string::npos);
  EXPECT_NE(refusal_of({{"frame_id", std::string{}}}).find("frame_id"), std::string::npos);
}

TEST(ImuParameters, a_standard_deviation_of_zero_is_out_of_range) {
  RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("orientation_stddev", 0.0);
  EXPECT_THROW(ImuComponent{options}, exceptions::InvalidParameterValueException);
}

TEST(ImuStream, decoding_and_joining_allocate_nothing) {
  RecordingContext context;
  const NodeOptions options{context};
  LifecycleNode node{"test", options};
  DeviceWatch watch{node, {}, {"imu"}, context.clock().now()};
  const ImuPublishers publishers{node.create_publisher<Imu>("a", QoS(5)), node.create_publisher<Imu>("b", QoS(5)),
                                 node.create_publisher<MagneticField>("c", QoS(5)), nullptr};
  Wt901Reader reader{kOutputMask, 1.5e-7, io::byte_time(115200), 10ms};
  ImuStream stream{{}, reader, context.clock(), publishers, node.get_logger(), watch};
  ScriptedImu imu;
  std::vector<Bytes> samples;
  samples.reserve(300);
  for (int i = 0; i < 300; ++i) samples.push_back(imu.sample(ScriptedImu::at_rest()).bytes);
  const test::AllocationGuard guard;
  for (const Bytes& sample : samples) stream.on_bytes(sample, context.clock().now());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(stream.counters().device.samples, 300U);
}

TEST(ImuOnTheLine, calibrates_and_publishes_through_a_real_terminal) {
  simulation::WorldSettings settings{.seed = 2};
  settings.errors.gyro_bias_dps = 2.0;  // so that a bias that stays is plain to see
  simulation::RunningWorld world{"imu_component", settings};
  RecordingContext context{world.clock()};
  NodeOptions options{context};
  options.append_parameter_override("port", world.path("imu"));
  ImuComponent imu{options};
  const auto configured = imu.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  const auto activated = imu.trigger(Transition::Activate);
  ASSERT_TRUE(activated.success) << activated.reason;
  ASSERT_TRUE(context.wait_for("/imu/data", 50, 30s));

  const auto messages = context.published<Imu>("/imu/data");
  std::array<double, 3> mean{};
  for (const Imu& message : messages) {
    mean[0] += message.angular_velocity.x / static_cast<double>(messages.size());
    mean[1] += message.angular_velocity.y / static_cast<double>(messages.size());
    mean[2] += message.angular_velocity.z / static_cast<double>(messages.size());
  }
  // 0.1 deg/s of noise: the bias from 100 samples, the mean from 50 or more; six standard deviations of their
  // difference.
  for (const double axis : mean) EXPECT_NEAR(axis, 0.0, 6 * 0.1 * kDeg * std::sqrt(1.0 / 100 + 1.0 / 50));
  EXPECT_NEAR(messages.back().linear_acceleration.z, 9.81, 0.2);
  ASSERT_TRUE(imu.trigger(Transition::Deactivate).success);
  EXPECT_TRUE(context.faults().empty());
}

}  // namespace
}  // namespace nacelle::imu
