// SPDX-License-Identifier: Apache-2.0
// The component over a scripted bus, on which emulators of the chips sit that share no code with the decoders.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "imu/component/imu_component.hpp"
#include "nacelle/io/scripted_bus.hpp"
#include "nacelle/io/scripted_stream.hpp"
#include "simulation/protocol/invensense_chips.hpp"
#include "simulation/protocol/st_and_bosch_chips.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::imu {
namespace {

using sensor_msgs::msg::Imu;
using sensor_msgs::msg::MagneticField;
using sensor_msgs::msg::Temperature;
using simulation::ImuTruth;
using simulation::RegisterChip;

constexpr double kRadPerDps = std::numbers::pi / 180.0;
constexpr double kMps2PerG = 9.80665;

template <typename Message>
Duration stamp_of(const Message& message) {
  return time_of(message.header.stamp).since_origin;
}

/// A board with chips on a bus, in manual time.
class Board {
 public:
  explicit Board(test::ManualClock& clock) : clock_(clock) {}
  void put(std::uint8_t address, RegisterChip& chip, std::function<bool()> answers = {}) {
    chips_.push_back({address, &chip, std::move(answers)});
  }
  void clear() { chips_.clear(); }
  std::unique_ptr<io::ScriptedBus> make_bus() {
    auto made = std::make_unique<io::ScriptedBus>([this](MonotonicTime until) {
      const Duration dt = until - clock_.now();
      if (dt <= Duration::zero()) return;
      clock_.advance(dt);
      for (const auto& chip : chips_) chip.chip->advance(to_seconds(dt), truth);
    });
    for (const auto& chip : chips_) {
      made->attach(chip.address, [&chip](ByteView out, ByteSpan in) {
        return (!chip.answers || chip.answers()) && chip.chip->transfer(out, in);
      });
    }
    bus = made.get();
    bus->allow_until(clock_.now() + 5s);
    return made;
  }

  ImuTruth truth{.acceleration_g = {0.1, -0.2, 0.97},
                 .rate_dps = {10.0, -20.0, 30.0},
                 .field_ut = {20.0, 5.0, -43.0},
                 .temperature_c = 31.0};
  io::ScriptedBus* bus = nullptr;

 private:
  struct Placed {
    std::uint8_t address;
    RegisterChip* chip;
    std::function<bool()> answers;
  };
  test::ManualClock& clock_;
  std::vector<Placed> chips_;
};

class ImuChips : public ::testing::Test {
 protected:
  ImuChips() {
    board_.put(0x68, mpu_);
    set("calibrate_gyro", false);
  }
  // The reading thread ends before the chips that a derived fixture holds.
  void TearDown() override { component_.reset(); }
  void set(const std::string& name, const ParameterValue& value) { overrides_.insert_or_assign(name, value); }
  ImuComponent& make(const std::string& model) {
    set("model", model);
    NodeOptions options{context_};
    options.parameter_overrides(overrides_);
    component_ = std::make_unique<ImuComponent>(
        options, ImuPorts{{}, [this](const ImuOptions&, const Clock&) {
                            return Result<std::unique_ptr<io::RegisterBus>, Problem>{board_.make_bus()};
                          }});
    return *component_;
  }
  void start(const std::string& model) {
    ImuComponent& imu = make(model);
    const auto configured = imu.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    const auto activated = imu.trigger(Transition::Activate);
    ASSERT_TRUE(activated.success) << activated.reason;
    run(5s);  // what was allowed at once
  }
  void run(Duration by) {
    until_ = std::max(until_, context_.clock().now()) + by;
    board_.bus->run_until(until_);
  }
  std::vector<Imu> last(std::size_t count) {
    auto all = context_.published<Imu>("/imu/data_raw");
    EXPECT_GE(all.size(), count);
    return {all.end() - static_cast<std::ptrdiff_t>(std::min(count, all.size())), all.end()};
  }

  test::RecordingContext context_;
  simulation::MpuChip mpu_{false};
  Board board_{context_.clock()};
  std::map<std::string, ParameterValue> overrides_;
  MonotonicTime until_{};
  std::unique_ptr<ImuComponent> component_;
};

struct ModelCase {
  const char* model;
  double rate_hz;
  bool use_fifo;
  double mps2, rps, tesla;  // the size of a count; tesla 0: no magnetometer
  double kelvin;
};

void PrintTo(const ModelCase& c, std::ostream* out) {
  *out << c.model << " at " << c.rate_hz << (c.use_fifo ? " fifo" : " direct");
}

class EveryModel : public ImuChips, public ::testing::WithParamInterface<ModelCase> {
 protected:
  EveryModel() {
    const std::string model = GetParam().model;
    board_.clear();
    if (model == "mpu6050") board_.put(0x68, mpu_);
    if (model == "mpu9250") {
      board_.put(0x68, mpu9250_);
      board_.put(0x0C, ak8963_, [this] { return mpu9250_.bypasses(); });
    }
    if (model == "icm20948") {
      board_.put(0x68, icm_);
      board_.put(0x0C, ak09916_, [this] { return icm_.bypasses(); });
    }
    if (model == "lsm6dsox") {
      board_.put(0x6A, lsm_);
      board_.put(0x1C, lis_);
    }
    if (model == "bmi088") {
      board_.put(0x18, bmi_accel_);
      board_.put(0x68, bmi_gyro_);
    }
    if (model == "bno055") board_.put(0x28, bno_);
    set("rate", GetParam().rate_hz);
    set("use_fifo", GetParam().use_fifo);
  }

  simulation::MpuChip mpu9250_{true};
  simulation::CompassChip ak8963_{false}, ak09916_{true};
  simulation::Icm20948Chip icm_;
  simulation::Lsm6dsoxChip lsm_;
  simulation::Lis3mdlChip lis_;
  simulation::Bmi088AccelChip bmi_accel_;
  simulation::Bmi088GyroChip bmi_gyro_;
  simulation::Bno055Chip bno_;
};

TEST_P(EveryModel, publishes_what_the_chip_feels_at_its_rate_with_stamps_of_its_clock) {
  const ModelCase& c = GetParam();
  ASSERT_NO_FATAL_FAILURE(start(c.model));
  const std::size_t before = context_.published<Imu>("/imu/data_raw").size();
  run(2s);
  const std::size_t made = context_.published<Imu>("/imu/data_raw").size() - before;
  EXPECT_NEAR(static_cast<double>(made), 2.0 * c.rate_hz, 0.01 * c.rate_hz + 2);

  const auto messages = last(made - 2);
  const Duration period = from_seconds(1.0 / c.rate_hz);
  for (std::size_t i = 1; i < messages.size(); ++i) {
    const Duration step = stamp_of(messages[i]) - stamp_of(messages[i - 1]);
    // Which part of a period before the poll a FIFO's last reading was made is not known: steps may move by that.
    EXPECT_GT(step, period * 3 / 4) << i;
    EXPECT_LT(step, period * 5 / 4) << i;
  }
  for (const Imu& m : {messages.front(), messages.back()}) {
    EXPECT_NEAR(m.linear_acceleration.x, 0.1 * kMps2PerG, c.mps2);
    EXPECT_NEAR(m.linear_acceleration.y, -0.2 * kMps2PerG, c.mps2);
    EXPECT_NEAR(m.linear_acceleration.z, 0.97 * kMps2PerG, c.mps2);
    EXPECT_NEAR(m.angular_velocity.x, 10 * kRadPerDps, c.rps);
    EXPECT_NEAR(m.angular_velocity.y, -20 * kRadPerDps, c.rps);
    EXPECT_NEAR(m.angular_velocity.z, 30 * kRadPerDps, c.rps);
    EXPECT_EQ(m.orientation_covariance[0], -1.0);
    EXPECT_GT(m.angular_velocity_covariance[0], 0.0);
    EXPECT_GT(m.linear_acceleration_covariance[0], 0.0);
  }
  const auto fields = context_.published<MagneticField>("/imu/mag");
  EXPECT_EQ(fields.empty(), c.tesla == 0.0);
  if (!fields.empty()) {
    EXPECT_NEAR(fields.back().magnetic_field.x, 20e-6, c.tesla);
    EXPECT_NEAR(fields.back().magnetic_field.y, 5e-6, c.tesla);
    EXPECT_NEAR(fields.back().magnetic_field.z, -43e-6, c.tesla);
    EXPECT_GT(fields.back().magnetic_field_covariance[0], 0.0);
  }
  const auto temperatures = context_.published<Temperature>("/imu/temperature");
  ASSERT_FALSE(temperatures.empty());
  EXPECT_NEAR(temperatures.back().temperature, 31.0, c.kelvin);
  EXPECT_LE(temperatures.size(), 9U) << "once a second";
  EXPECT_TRUE(context_.faults().empty());
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_P(EveryModel, a_chip_that_lost_its_power_is_an_open_fault_and_is_set_up_anew) {
  ASSERT_NO_FATAL_FAILURE(start(GetParam().model));
  const auto set_power = [this](bool on) {
    for (RegisterChip* const chip : std::initializer_list<RegisterChip*>{&mpu_, &mpu9250_, &ak8963_, &ak09916_, &icm_,
                                                                         &lsm_, &lis_, &bmi_accel_, &bmi_gyro_, &bno_})
      board_.bus->between_transfers([&] { chip->set_power(on); });
  };
  set_power(false);
  // The reader meets the missing chip, and tries again in pauses of real time: nothing more may be waited for here than an event.
  board_.bus->allow_until(until_ + 100s);
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_NE(context_.open_faults()[0].text.find("no device answers at its address"), std::string::npos)
      << context_.open_faults()[0].text;
  const std::size_t before = context_.published<Imu>("/imu/data_raw").size();
  set_power(true);
  ASSERT_TRUE(context_.wait_for("/imu/data_raw", before + 20, 60s));
  EXPECT_NEAR(context_.published<Imu>("/imu/data_raw").back().angular_velocity.z, 30 * kRadPerDps, GetParam().rps);
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(ImuChips, another_chip_is_refused_with_what_it_says) {
  simulation::MpuChip other{true};
  board_.clear();
  board_.put(0x68, other);
  const auto outcome = make("mpu6050").trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("0x68: register 0x75 is 0x71, that of the MPU-6050 is 0x68; another chip is there"),
            std::string::npos)
      << outcome.reason;
}

TEST_F(ImuChips, a_required_chip_that_does_not_answer_fails_the_configuration) {
  set("required_device", true);
  board_.clear();
  const auto outcome = make("mpu6050").trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("0x68: no device answers at its address (NAK"), std::string::npos) << outcome.reason;
  EXPECT_NE(outcome.reason.find("i2cdetect"), std::string::npos) << outcome.reason;
}

TEST_F(ImuChips, a_chip_that_comes_later_is_awaited) {
  mpu_.set_power(false);
  ImuComponent& imu = make("mpu6050");
  ASSERT_TRUE(imu.trigger(Transition::Configure).success);
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  EXPECT_EQ(context_.open_faults().size(), 1U);
  board_.bus->allow_until(context_.clock().now() + 100s);
  board_.bus->between_transfers([this] { mpu_.set_power(true); });
  ASSERT_TRUE(context_.wait_for("/imu/data_raw", 10, 60s));
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(ImuChips, a_chip_is_opened_once_and_its_bus_is_shared) {
  ASSERT_EQ(make("mpu6050").device_uses().size(), 1U);
  EXPECT_EQ(component_->device_uses()[0].path, "/dev/i2c-1 address 0x68");
}

TEST_F(ImuChips, a_stuck_bus_is_an_open_fault_that_says_so_and_what_helps) {
  ASSERT_NO_FATAL_FAILURE(start("mpu6050"));
  board_.bus->fail(io::StreamFault::BusStuck);
  board_.bus->allow_until(until_ + 100s);
  context_.wait_for_open_faults(1);
  EXPECT_NE(context_.open_faults()[0].text.find("the bus is stuck"), std::string::npos)
      << context_.open_faults()[0].text;
  EXPECT_NE(context_.open_faults()[0].text.find("power cycle"), std::string::npos) << context_.open_faults()[0].text;
}

TEST_F(ImuChips, every_seventh_transfer_lost_costs_no_reading) {
  set("use_fifo", false);
  ASSERT_NO_FATAL_FAILURE(start("mpu6050"));
  const std::size_t before = context_.published<Imu>("/imu/data_raw").size();
  board_.bus->lose_every(7);
  run(1s);
  EXPECT_NEAR(static_cast<double>(context_.published<Imu>("/imu/data_raw").size() - before), 100.0, 1.0);
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(ImuChips, a_fifo_that_overflowed_while_the_thread_was_away_is_set_up_anew) {
  set("rate", 1000.0);
  ASSERT_NO_FATAL_FAILURE(start("mpu6050"));
  const std::uint64_t before = context_.published<Imu>("/imu/data_raw").size();
  mpu_.advance(0.2, board_.truth);  // 200 readings at once: 2800 bytes into 1024
  board_.bus->allow_until(until_ + 100s);
  ASSERT_TRUE(context_.wait_for("/imu/data_raw", before + 100, 60s));
  for (const Imu& m : last(100))
    EXPECT_NEAR(m.angular_velocity.z, 30 * kRadPerDps, kRadPerDps / 65.5) << "cut in a record";
}

TEST_F(ImuChips, stamps_follow_the_chips_own_clock) {
  // The chip's crystal runs 0.5 % fast: by its own clock 104 Hz are 9615 us, by the world's 9568.
  simulation::Lsm6dsoxChip lsm;
  lsm.clock_error = 0.005;
  board_.clear();
  board_.put(0x6A, lsm);
  set("mag_address", std::int64_t{0});
  ASSERT_NO_FATAL_FAILURE(start("lsm6dsox"));
  run(20s);
  // Each 201 steps the stamps are a reading ahead, and two steps of half a period follow: the mean is that of whole such rounds.
  constexpr std::size_t kSteps = 1005;
  const auto messages = last(kSteps + 1);
  const double mean_s = to_seconds(stamp_of(messages.back()) - stamp_of(messages.front())) / kSteps;
  EXPECT_NEAR(mean_s, 1.0 / 104 / 1.005, 5e-6);
}

TEST_F(ImuChips, ranges_are_parameters) {
  set("accel_range", std::int64_t{16});
  set("gyro_range", std::int64_t{2000});
  board_.truth.acceleration_g = {0.0, 0.0, 12.0};
  board_.truth.rate_dps = {1500.0, 0.0, 0.0};
  ASSERT_NO_FATAL_FAILURE(start("mpu6050"));
  const Imu m = last(1)[0];
  EXPECT_NEAR(m.linear_acceleration.z, 12.0 * kMps2PerG, 16 * kMps2PerG / 32768);
  EXPECT_NEAR(m.angular_velocity.x, 1500.0 * kRadPerDps, kRadPerDps / 16.4);
}

TEST_F(ImuChips, an_impossible_range_rate_or_address_is_refused_with_those_that_there_are) {
  const auto refusal = [this](const std::string& model, const std::string& name, const ParameterValue& value) {
    overrides_ = {{name, value}};
    return make(model).trigger(Transition::Configure).reason;
  };
  EXPECT_NE(refusal("mpu6050", "accel_range", std::int64_t{3}).find("it has 2 4 8 16"), std::string::npos);
  EXPECT_NE(refusal("bmi088", "gyro_range", std::int64_t{300}).find("it has 125 250 500 1000 2000"), std::string::npos);
  EXPECT_NE(refusal("lsm6dsox", "rate", 100.0).find("it has 12.5 26 52 104"), std::string::npos);
  EXPECT_NE(refusal("bno055", "rate", 200.0).find("at most 100 Hz"), std::string::npos);
  EXPECT_NE(refusal("mpu6050", "address", std::int64_t{3}).find("3 is no I2C address"), std::string::npos);
  EXPECT_NE(refusal("mpu9999", "use_fifo", true).find("'mpu9999' is not supported; it is one of wt901"),
            std::string::npos);
}

TEST_F(ImuChips, corrections_are_taken_off_in_the_sensors_axes_and_the_mounting_turns_the_rest) {
  set("gyro_bias", std::vector<double>{10 * kRadPerDps, 0.0, 0.0});
  set("accel_bias", std::vector<double>{0.1 * kMps2PerG, 0.0, 0.0});
  set("accel_matrix", std::vector<double>{1, 0, 0, 0, 2, 0, 0, 0, 1});
  set("mounting_rpy", std::vector<double>{0.0, 0.0, std::numbers::pi / 2});  // the sensor's x points left
  ASSERT_NO_FATAL_FAILURE(start("mpu6050"));
  const Imu m = last(1)[0];
  EXPECT_NEAR(m.angular_velocity.x, 20 * kRadPerDps, 1e-3);
  EXPECT_NEAR(m.angular_velocity.y, 0.0, 1e-3);
  EXPECT_NEAR(m.linear_acceleration.x, 0.4 * kMps2PerG, 5e-3);
  EXPECT_NEAR(m.linear_acceleration.y, 0.0, 5e-3);
  EXPECT_NEAR(m.linear_acceleration.z, 0.97 * kMps2PerG, 5e-3);
}

TEST_F(ImuChips, a_bno055_publishes_its_orientation_turned_by_the_mounting) {
  simulation::Bno055Chip bno;
  board_.clear();
  board_.put(0x28, bno);
  const double half = std::numbers::pi / 4;
  board_.truth.quaternion = {std::cos(half), 0.0, 0.0, std::sin(half)};  // yaw 90 degrees
  set("mounting_rpy", std::vector<double>{0.0, 0.0, std::numbers::pi / 2});
  ASSERT_NO_FATAL_FAILURE(start("bno055"));
  const auto oriented = context_.published<Imu>("/imu/data");
  ASSERT_FALSE(oriented.empty());
  EXPECT_NEAR(oriented.back().orientation.w, 1.0, 1e-3);
  EXPECT_GT(oriented.back().orientation_covariance[0], 0.0);
}

TEST_F(ImuChips, a_chip_without_orientation_leaves_imu_data_to_a_filter) {
  ASSERT_NO_FATAL_FAILURE(start("mpu6050"));
  EXPECT_TRUE(context_.published<Imu>("/imu/data").empty());
}

/// A serial line on which time goes on when nothing comes.
class SerialImu : public ImuChips {
 protected:
  ImuComponent& make_on_line(const std::string& model, const std::vector<io::ScriptedStream::Step>& script,
                             const std::function<Bytes(ByteView)>& device = {}) {
    set("model", model);
    NodeOptions options{context_};
    options.parameter_overrides(overrides_);
    component_ = std::make_unique<ImuComponent>(
        options, ImuPorts{[this, script, device](const ImuOptions&, const Clock&) {
                            auto line = std::make_unique<io::ScriptedStream>(
                                script, device ? io::ScriptedStream::AtEnd::Silence : io::ScriptedStream::AtEnd::Blocks,
                                [this](MonotonicTime until) { pass(until); });
                            if (device) line->answer_writes(device);
                            line_ = line.get();
                            return Result<std::unique_ptr<io::ByteStream>, Problem>{std::move(line)};
                          },
                          {}});
    return *component_;
  }
  void pass(MonotonicTime until) {
    const Duration dt = until - context_.clock().now();
    if (dt <= Duration::zero()) return;
    context_.clock().advance(dt);
    bno_.advance(to_seconds(dt), board_.truth);
  }
  simulation::Bno055Chip bno_;
  io::ScriptedStream* line_ = nullptr;
};

TEST_F(SerialImu, a_bno055_is_asked_over_its_line_and_asked_again_when_its_bus_was_overrun) {
  bno_.overruns = 3;
  ImuComponent& imu = make_on_line("bno055_uart", {}, [this](ByteView bytes) { return bno_.serial(bytes); });
  const auto configured = imu.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  ASSERT_TRUE(context_.wait_for("/imu/data", 20, 60s));
  const Imu m = context_.published<Imu>("/imu/data").back();
  EXPECT_NEAR(m.angular_velocity.z, 30 * kRadPerDps, kRadPerDps / 16);
  EXPECT_NEAR(m.linear_acceleration.z, 0.97 * kMps2PerG, 0.01);
  EXPECT_NEAR(m.orientation.w, 1.0, 1e-3);
  EXPECT_EQ(bno_.value(0x3D), 0x0C);
}

TEST_F(SerialImu, a_bno08x_publishes_orientation_and_acceleration_and_says_that_it_has_no_gyro) {
  std::vector<io::ScriptedStream::Step> script;
  for (int i = 0; i < 50; ++i) {
    // Index 20 to 24 are lost on the way.
    if (i >= 20 && i < 25) continue;
    const auto frame = simulation::print_rvc(static_cast<std::uint8_t>(240 + i), {90.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
    script.push_back({MonotonicTime{1s} + (i + 1) * 10ms, Bytes(frame.begin(), frame.end()), {}});
  }
  ImuComponent& imu = make_on_line("bno08x_rvc", script);
  const auto configured = imu.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  ASSERT_TRUE(imu.trigger(Transition::Activate).success);
  line_->wait_until_read();
  for (int i = 50; i < 60; ++i) {
    const auto frame = simulation::print_rvc(static_cast<std::uint8_t>(240 + i), {90.0, 0.0, 0.0}, {0.0, 0.0, 1.0});
    line_->append({MonotonicTime{1s} + (i + 1) * 10ms, Bytes(frame.begin(), frame.end()), {}});
  }
  line_->wait_until_read();
  const auto messages = context_.published<Imu>("/imu/data");
  ASSERT_GE(messages.size(), 10U);
  const Imu& m = messages.back();
  EXPECT_NEAR(m.orientation.z, std::sqrt(0.5), 1e-4);
  EXPECT_NEAR(m.linear_acceleration.z, kMps2PerG, 1e-2);
  EXPECT_EQ(m.angular_velocity_covariance[0], -1.0);
  EXPECT_GT(m.orientation_covariance[0], 0.0);
  EXPECT_EQ(stamp_of(messages[messages.size() - 1]) - stamp_of(messages[messages.size() - 2]), 10ms);
  EXPECT_TRUE(context_.published<MagneticField>("/imu/mag").empty());
}

TEST(ChipReader, takes_nothing_from_the_heap_per_poll) {
  ChipUnits units;
  units.acceleration_mps2 = units.angular_velocity_rps = 1e-3;
  units.period = 10ms;
  ChipReader reader{std::make_unique<InvensenseDecoder>(false, InvensenseDecoder::Compass::None), units};
  struct Count final : SampleSink {
    void on_sample(const Sample&, Duration) override { ++samples; }
    int samples = 0;
  } count;
  Bytes poll{1, 28, 0};
  for (int i = 0; i < 28; ++i) poll.push_back(static_cast<std::uint8_t>(i));
  const test::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) reader.feed(poll, MonotonicTime{i * 20ms}, count);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(count.samples, 200);
}

constexpr double kG4 = 4 * kMps2PerG / 32768, kG6 = 6 * kMps2PerG / 32768;
INSTANTIATE_TEST_SUITE_P(
    Chips, EveryModel,
    ::testing::Values(ModelCase{"mpu6050", 100, true, kG4, kRadPerDps / 65.5, 0, 0.01},
                      ModelCase{"mpu6050", 1000, true, kG4, kRadPerDps / 65.5, 0, 0.01},
                      ModelCase{"mpu6050", 100, false, kG4, kRadPerDps / 65.5, 0, 0.01},
                      ModelCase{"mpu9250", 200, true, kG4, kRadPerDps / 65.5, 0.15e-6, 0.01},
                      ModelCase{"icm20948", 100, true, kG4, kRadPerDps / 65.5, 0.15e-6, 0.01},
                      ModelCase{"icm20948", 220, false, kG4, kRadPerDps / 65.5, 0.15e-6, 0.01},
                      ModelCase{"lsm6dsox", 104, true, 0.122e-3 * kMps2PerG, 0.0175 * kRadPerDps, 1.5e-8, 0.01},
                      ModelCase{"lsm6dsox", 833, true, 0.122e-3 * kMps2PerG, 0.0175 * kRadPerDps, 1.5e-8, 0.01},
                      ModelCase{"bmi088", 100, true, kG6, 500.0 / 32767 * kRadPerDps, 0, 0.13},
                      ModelCase{"bmi088", 400, true, kG6, 500.0 / 32767 * kRadPerDps, 0, 0.13},
                      ModelCase{"bmi088", 200, false, kG6, 500.0 / 32767 * kRadPerDps, 0, 0.13},
                      ModelCase{"bno055", 100, true, 0.01, kRadPerDps / 16, 1e-6 / 16, 0.6}));

}  // namespace
}  // namespace nacelle::imu
