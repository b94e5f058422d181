// SPDX-License-Identifier: Apache-2.0
#include "imu/component/chip_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace nacelle::imu {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr auto kCheck = RegisterStep::Kind::Check;

std::uint8_t byte(unsigned value) { return static_cast<std::uint8_t>(value); }
std::uint8_t tag(BlockTag kind) { return static_cast<std::uint8_t>(kind); }
/// The place of a range in the list of those that there are: the bits of the register.
unsigned index_of(std::span<const int> ranges, int range) {
  return static_cast<unsigned>(std::ranges::find(ranges, range) - ranges.begin());
}
/// Low-pass filter of MPU-6050, MPU-9250 and ICM-20948 (nearly the same in all): below half the rate.
unsigned low_pass(double rate_hz) {
  return rate_hz >= 400 ? 1 : rate_hz >= 200 ? 2 : rate_hz >= 100 ? 3 : rate_hz >= 50 ? 4 : rate_hz >= 25 ? 5 : 6;
}

RegisterStep check(std::uint8_t address, std::uint8_t reg, std::uint8_t value, const char* chip,
                   std::uint8_t also = 0) {
  return {.kind = kCheck, .address = address, .reg = reg, .value = value, .chip = chip, .also = also};
}

/// A list of writes to one chip.
class Steps {
 public:
  Steps(std::vector<RegisterStep>& into, std::uint8_t address) : into_(into), address_(address) {}
  Steps& write(unsigned reg, unsigned value, Duration pause = {}) {
    into_.push_back({.address = address_, .reg = byte(reg), .value = byte(value), .pause = pause});
    return *this;
  }

 private:
  std::vector<RegisterStep>& into_;
  std::uint8_t address_;
};

io::PollBlock fifo(BlockTag kind, std::uint8_t address, unsigned reg, std::size_t record, std::size_t records,
                   io::PollBlock::Fill fill, std::size_t full = 0) {
  return {.tag = tag(kind),
          .address = address,
          .reg = byte(reg),
          .length = static_cast<std::uint16_t>(record),
          .fill = fill,
          .most = static_cast<std::uint16_t>(record * records),
          .full = static_cast<std::uint16_t>(full)};
}
io::PollBlock registers(BlockTag kind, std::uint8_t address, unsigned reg, std::size_t length) {
  return {.tag = tag(kind), .address = address, .reg = byte(reg), .length = static_cast<std::uint16_t>(length)};
}

// Sources: RM-MPU-6000A, RM-MPU-9250A, AK8963 data sheet.
void plan_mpu(const ImuOptions& o, ChipPlan& plan) {
  const bool is_9250 = o.model == ImuModel::Mpu9250;
  const auto address = o.address;
  if (is_9250) {
    plan.set_up.push_back(check(address, 0x75, 0x71, "MPU-9250", 0x73));  // 73: MPU-9255
  } else {
    plan.set_up.push_back(check(address, 0x75, 0x68, "MPU-6050"));
  }
  const unsigned gyro = index_of(o.traits->angular_velocity_ranges_dps, o.gyro_range_dps);
  const unsigned accel = index_of(o.traits->acceleration_ranges_g, o.accel_range_g);
  Steps chip{plan.set_up, address};
  chip.write(0x6B, 0x80, 100ms).write(0x6B, 0x01, 10ms).write(0x6C, 0x00);
  chip.write(0x1A, low_pass(o.rate_hz)).write(0x19, static_cast<unsigned>(std::lround(1000.0 / o.rate_hz)) - 1);
  chip.write(0x1B, gyro << 3U).write(0x1C, accel << 3U);
  if (is_9250) chip.write(0x1D, low_pass(o.rate_hz)).write(0x37, 0x02, 1ms);
  constexpr std::uint8_t kCompass = 0x0C;
  if (is_9250) {
    plan.set_up.push_back(check(kCompass, 0x00, 0x48, "AK8963"));
    Steps{plan.set_up, kCompass}.write(0x0A, 0x00, 1ms).write(0x0A, 0x16, 1ms);
    plan.blocks.push_back(registers(BlockTag::Field, kCompass, 0x02, 8));
  }
  if (o.use_fifo) {
    chip.write(0x23, 0x00).write(0x6A, 0x04, 1ms).write(0x6A, 0x40).write(0x23, 0xF8);
    const std::size_t size = is_9250 ? 512 : 1024;
    plan.blocks.push_back(fifo(BlockTag::Record, address, 0x74, InvensenseDecoder::kRecordBytes, 36,
                               {.reg = 0x72, .mask = 0x1FFF}, size - InvensenseDecoder::kRecordBytes + 1));
  } else {
    plan.blocks.push_back(registers(BlockTag::Record, address, 0x3B, InvensenseDecoder::kRecordBytes));
  }
  plan.units.acceleration_mps2 = o.accel_range_g * kGravityMps2 / 32768.0;
  plan.units.angular_velocity_rps = std::array{1 / 131.0, 1 / 65.5, 1 / 32.8, 1 / 16.4}[gyro] * kRadPerDeg;
  plan.units.temperature_k = is_9250 ? 1 / 333.87 : 1 / 340.0;
  plan.units.temperature_at_zero_c = is_9250 ? 21.0 : 36.53;
  if (is_9250) {
    plan.units.magnetic_field_t = 0.15e-6;
    plan.units.field_axes = {ChipUnits::Axis{1, 1.0}, ChipUnits::Axis{0, 1.0}, ChipUnits::Axis{2, -1.0}};
  }
  plan.decoder = std::make_unique<InvensenseDecoder>(
      false, is_9250 ? InvensenseDecoder::Compass::Ak8963 : InvensenseDecoder::Compass::None);
}

// Sources: DS-000189 (ICM-20948), AK09916 data sheet. y and z of the compass point against those of the gyro.
void plan_icm20948(const ImuOptions& o, ChipPlan& plan) {
  constexpr std::uint8_t kCompass = 0x0C;
  const unsigned gyro = index_of(o.traits->angular_velocity_ranges_dps, o.gyro_range_dps);
  const unsigned accel = index_of(o.traits->acceleration_ranges_g, o.accel_range_g);
  Steps chip{plan.set_up, o.address};
  chip.write(0x7F, 0x00);
  plan.set_up.push_back(check(o.address, 0x00, 0xEA, "ICM-20948"));
  chip.write(0x06, 0x80, 100ms).write(0x06, 0x01, 30ms).write(0x07, 0x00);
  const auto divider = static_cast<unsigned>(std::lround(1100.0 / o.rate_hz)) - 1;
  const unsigned filter = low_pass(o.rate_hz);
  chip.write(0x7F, 0x20).write(0x00, divider).write(0x01, filter << 3U | gyro << 1U | 1U);
  chip.write(0x10, 0).write(0x11, divider).write(0x14, filter << 3U | accel << 1U | 1U);
  chip.write(0x7F, 0x00).write(0x0F, 0x02, 1ms);
  plan.set_up.push_back(check(kCompass, 0x01, 0x09, "AK09916"));
  Steps{plan.set_up, kCompass}.write(0x32, 0x01, 10ms).write(0x31, 0x08, 1ms);
  plan.blocks.push_back(registers(BlockTag::Field, kCompass, 0x10, 9));
  if (o.use_fifo) {
    chip.write(0x03, 0x00).write(0x66, 0x00).write(0x67, 0x00).write(0x69, 0x00);
    chip.write(0x68, 0x1F, 1ms).write(0x68, 0x00).write(0x03, 0x40).write(0x67, 0x1F);
    plan.blocks.push_back(fifo(BlockTag::Record, o.address, 0x72, InvensenseDecoder::kRecordBytes, 36,
                               {.reg = 0x70, .mask = 0x1FFF}, 512 - InvensenseDecoder::kRecordBytes + 1));
  } else {
    plan.blocks.push_back(registers(BlockTag::Record, o.address, 0x2D, InvensenseDecoder::kRecordBytes));
  }
  plan.units.acceleration_mps2 = o.accel_range_g * kGravityMps2 / 32768.0;
  plan.units.angular_velocity_rps = std::array{1 / 131.0, 1 / 65.5, 1 / 32.8, 1 / 16.4}[gyro] * kRadPerDeg;
  plan.units.temperature_k = 1 / 333.87;
  plan.units.temperature_at_zero_c = 21.0;
  plan.units.magnetic_field_t = 0.15e-6;
  plan.units.field_axes = {ChipUnits::Axis{0, 1.0}, ChipUnits::Axis{1, -1.0}, ChipUnits::Axis{2, -1.0}};
  plan.decoder = std::make_unique<InvensenseDecoder>(true, InvensenseDecoder::Compass::Ak09916);
}

constexpr std::array kLsmRatesHz{12.5, 26.0, 52.0, 104.0, 208.0, 416.0, 833.0};

// Sources: DS12814 (LSM6DSOX), DocID024204 (LIS3MDL).
void plan_lsm6dsox(const ImuOptions& o, ChipPlan& plan) {
  const auto rate = static_cast<unsigned>(std::ranges::find(kLsmRatesHz, o.rate_hz) - kLsmRatesHz.begin()) + 1;
  const unsigned accel = index_of(o.traits->acceleration_ranges_g, o.accel_range_g);
  const unsigned gyro = index_of(o.traits->angular_velocity_ranges_dps, o.gyro_range_dps);
  constexpr std::array kAccelBits{0U, 2U, 3U, 1U};
  constexpr std::array kGyroBits{1U, 0U, 2U, 4U, 6U};
  plan.set_up.push_back(check(o.address, 0x0F, 0x6C, "LSM6DSOX"));
  Steps chip{plan.set_up, o.address};
  chip.write(0x12, 0x01, 10ms).write(0x12, 0x44);
  chip.write(0x10, rate << 4U | kAccelBits[accel] << 2U).write(0x11, rate << 4U | kGyroBits[gyro] << 1U);
  if (o.mag_address != 0) {
    plan.set_up.push_back(check(o.mag_address, 0x0F, 0x3D, "LIS3MDL"));
    Steps{plan.set_up, o.mag_address}
        .write(0x21, 0x04, 10ms)
        .write(0x20, 0x7C)  // ultra-high performance, 80 Hz
        .write(0x21, 0x00)  // 4 gauss
        .write(0x23, 0x0C)
        .write(0x24, 0x40)
        .write(0x22, 0x00);
    plan.blocks.push_back(registers(BlockTag::Field, o.mag_address, 0x27 | 0x80, Lsm6dsoxDecoder::kFieldBytes));
  }
  if (o.use_fifo) {
    chip.write(0x0A, 0x00).write(0x19, 0x20).write(0x09, rate << 4U | rate).write(0x0A, 0x46);
    plan.blocks.push_back(registers(BlockTag::Temperature, o.address, 0x20, 2));
    plan.blocks.push_back(fifo(BlockTag::Record, o.address, 0x78, Lsm6dsoxDecoder::kWordBytes, 128,
                               {.reg = 0x3A, .big_endian = false, .mask = 0x03FF, .unit = 7}));
  } else {
    plan.blocks.push_back(registers(BlockTag::Record, o.address, 0x20, Lsm6dsoxDecoder::kRecordBytes));
  }
  plan.units.acceleration_mps2 = std::array{0.061, 0.122, 0.244, 0.488}[accel] * 1e-3 * kGravityMps2;
  plan.units.angular_velocity_rps = std::array{4.375, 8.75, 17.5, 35.0, 70.0}[gyro] * 1e-3 * kRadPerDeg;
  plan.units.temperature_k = 1 / 256.0;
  plan.units.temperature_at_zero_c = 25.0;
  plan.units.magnetic_field_t = 1e-4 / 6842.0;
  plan.units.tick = 25us;
  plan.decoder = std::make_unique<Lsm6dsoxDecoder>(o.use_fifo);
}

constexpr std::array kBmiRatesHz{100.0, 200.0, 400.0};

// Source: BST-BMI088-DS001.
void plan_bmi088(const ImuOptions& o, ChipPlan& plan) {
  const std::uint8_t gyro_address = o.gyro_address;
  const auto rate = static_cast<std::size_t>(std::ranges::find(kBmiRatesHz, o.rate_hz) - kBmiRatesHz.begin());
  constexpr std::array kAccelRate{0x08U, 0x09U, 0x0AU};
  constexpr std::array kGyroBandwidth{0x05U, 0x04U, 0x03U};
  const unsigned accel = index_of(o.traits->acceleration_ranges_g, o.accel_range_g);
  const unsigned gyro = index_of(o.traits->angular_velocity_ranges_dps, o.gyro_range_dps);
  Steps chip{plan.set_up, o.address}, turn{plan.set_up, gyro_address};
  // The reset comes first: before it the accelerometer may not show its identity.
  chip.write(0x7E, 0xB6, 50ms);
  plan.set_up.push_back(check(o.address, 0x00, 0x1E, "BMI088's accelerometer"));
  chip.write(0x7C, 0x00, 5ms).write(0x7D, 0x04, 50ms).write(0x40, 0xA0U | kAccelRate[rate]).write(0x41, accel);
  plan.set_up.push_back(check(gyro_address, 0x00, 0x0F, "BMI088's gyro"));
  turn.write(0x14, 0xB6, 50ms).write(0x0F, 4 - gyro).write(0x10, kGyroBandwidth[rate]).write(0x11, 0x00);
  plan.blocks.push_back(registers(BlockTag::Temperature, o.address, 0x22, 2));
  if (o.use_fifo) {
    chip.write(0x48, 0x02).write(0x49, 0x50).write(0x7E, 0xB0);
    turn.write(0x3E, 0x80);
    plan.blocks.push_back(
        fifo(BlockTag::Acceleration, o.address, 0x26, 1, 1022, {.reg = 0x24, .big_endian = false, .mask = 0x3FFF}));
    plan.blocks.push_back(fifo(BlockTag::Record, gyro_address, 0x3F, Bmi088Decoder::kFrameBytes, 100,
                               {.reg = 0x0E, .has_two_bytes = false, .mask = 0x7F, .unit = 6}));
  } else {
    plan.blocks.push_back(registers(BlockTag::Direct, o.address, 0x12, Bmi088Decoder::kFrameBytes));
    plan.blocks.push_back(registers(BlockTag::Record, gyro_address, 0x02, Bmi088Decoder::kFrameBytes));
  }
  plan.units.acceleration_mps2 = o.accel_range_g * kGravityMps2 / 32768.0;
  plan.units.angular_velocity_rps = o.gyro_range_dps / 32767.0 * kRadPerDeg;
  plan.units.temperature_k = 0.125;
  plan.units.temperature_at_zero_c = 23.0;
  plan.decoder = std::make_unique<Bmi088Decoder>();
}

// Source: BST-BNO055-DS000. Mode NDOF: fusion of all three sensors.
void plan_bno055(const ImuOptions& o, ChipPlan& plan) {
  const std::uint8_t address = o.model == ImuModel::Bno055 ? o.address : std::uint8_t{0};
  plan.set_up.push_back(check(address, 0x00, 0xA0, "BNO055"));
  Steps chip{plan.set_up, address};
  chip.write(0x3D, 0x00, 20ms).write(0x07, 0x00).write(0x3E, 0x00, 1ms).write(0x3B, 0x00).write(0x3D, 0x0C, 20ms);
  plan.blocks.push_back(
      registers(BlockTag::Record, address, Bno055Decoder::kFirstRegister, Bno055Decoder::kRecordBytes));
  plan.units.acceleration_mps2 = 0.01;
  plan.units.angular_velocity_rps = kRadPerDeg / 16.0;
  plan.units.magnetic_field_t = 1e-6 / 16.0;
  plan.units.temperature_k = 1.0;
  plan.units.quaternion = 1.0 / 16384.0;
  plan.decoder = std::make_unique<Bno055Decoder>();
}

Result<double, std::string> one_of(std::span<const double> rates, double rate_hz) {
  if (std::ranges::find(rates, rate_hz) != rates.end()) return rate_hz;
  return err(fmt::format("it has {}", fmt::join(rates, " ")));
}

/// A clock of the chip divided by 1 to 256.
Result<double, std::string> divided(double clock_hz, double rate_hz) {
  const double divider = clock_hz / rate_hz;
  if (divider < 0.999 || divider > 256.001) return err(fmt::format("it has {} / n, n from 1 to 256", clock_hz));
  return clock_hz / std::max(1.0, std::round(divider));
}

}  // namespace

Result<double, std::string> chip_rate(ImuModel model, double rate_hz) {
  switch (model) {
    case ImuModel::Mpu6050:
    case ImuModel::Mpu9250: return divided(1000.0, rate_hz);
    case ImuModel::Icm20948: return divided(1100.0, rate_hz);
    case ImuModel::Lsm6dsox: return one_of(kLsmRatesHz, rate_hz);
    case ImuModel::Bmi088: return one_of(kBmiRatesHz, rate_hz);
    default: return rate_hz;
  }
}

ChipPlan plan_chip(const ImuOptions& options) {
  ChipPlan plan;
  switch (options.model) {
    case ImuModel::Mpu6050:
    case ImuModel::Mpu9250: plan_mpu(options, plan); break;
    case ImuModel::Icm20948: plan_icm20948(options, plan); break;
    case ImuModel::Lsm6dsox: plan_lsm6dsox(options, plan); break;
    case ImuModel::Bmi088: plan_bmi088(options, plan); break;
    default: plan_bno055(options, plan); break;
  }
  plan.units.period = from_seconds(1.0 / options.rate_hz);
  // A FIFO keeps what comes between two polls: 200 polls a second are enough for any rate.
  plan.poll_period = options.use_fifo ? std::max<Duration>(plan.units.period, 5ms) : plan.units.period;
  return plan;
}

Result<void, SetUpFault> set_up_chip(io::RegisterBus& bus, const std::vector<RegisterStep>& steps, const Clock& clock) {
  for (const auto& step : steps) {
    std::uint8_t seen = step.value;
    Result<void, io::StreamFault> done{};
    for (int attempt = 0; attempt < 3; ++attempt) {
      done = step.kind == kCheck ? read_registers(bus, step.address, step.reg, {&seen, 1})
                                 : write_register(bus, step.address, step.reg, step.value);
      if (done || done.error() != io::StreamFault::NoAnswer) break;
    }
    if (!done) {
      return err(SetUpFault{done.error(), fmt::format("0x{:02x}: {}", step.address, io::explain(done.error())),
                            "`i2cdetect -y N` shows which addresses answer"});
    }
    if (seen != step.value && (step.also == 0 || seen != step.also)) {
      return err(SetUpFault{io::StreamFault::NotUsable,
                            fmt::format("0x{:02x}: register 0x{:02x} is 0x{:02x}, that of the {} is 0x{:02x}",
                                        step.address, step.reg, seen, step.chip, step.value),
                            "another chip is there: set model"});
    }
    // An interrupted wait is a stop of the reading thread; the next transfer is soon over.
    if (step.pause > Duration::zero()) std::ignore = bus.wait_until(clock.now() + step.pause);
  }
  return {};
}

}  // namespace nacelle::imu
