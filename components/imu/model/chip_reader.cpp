// SPDX-License-Identifier: Apache-2.0
#include "imu/model/chip_reader.hpp"

#include <cmath>

namespace nacelle::imu {
namespace {

Vector3 in_unit(const Counts& counts, double unit) { return {counts[0] * unit, counts[1] * unit, counts[2] * unit}; }

std::optional<Orientation> orientation_of(const std::array<std::int16_t, 4>& counts, double unit) {
  const double w = counts[0] * unit, x = counts[1] * unit, y = counts[2] * unit, z = counts[3] * unit;
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  // Far from one it is no rotation: the device is still starting.
  if (std::abs(length - 1.0) > 0.1) return std::nullopt;
  return Orientation{w / length, x / length, y / length, z / length};
}

}  // namespace

Sample sample_of(const ChipReading& reading, const ChipUnits& units) {
  Sample sample;
  sample.acceleration_mps2 = in_unit(reading.acceleration, units.acceleration_mps2);
  sample.angular_velocity_rps = in_unit(reading.angular_velocity, units.angular_velocity_rps);
  if (reading.field && units.magnetic_field_t > 0.0) {
    Vector3 field{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& axis = units.field_axes[i];
      field[i] = axis.sign * units.magnetic_field_t * (*reading.field)[axis.index];
    }
    sample.magnetic_field_t = field;
  }
  if (reading.temperature && units.temperature_k > 0.0) {
    sample.temperature_c = *reading.temperature * units.temperature_k + units.temperature_at_zero_c;
  }
  if (reading.quaternion && units.quaternion > 0.0) {
    sample.orientation = orientation_of(*reading.quaternion, units.quaternion);
  }
  return sample;
}

ChipReader::ChipReader(std::unique_ptr<ChipDecoder> decoder, const ChipUnits& units)
    : decoder_(std::move(decoder)), units_(units) {
  polled_.reserve(kMostReadings);
}

void ChipReader::on_reading(const ChipReading& reading) {
  // No accelerometer reads exactly nothing on all axes: the chip sleeps, as after a loss of power.
  if (reading.acceleration == Counts{}) {
    ++asleep_;
  } else if (polled_.size() < kMostReadings) {
    polled_.push_back(reading);
  } else {
    ++lost_;
  }
}

Duration ChipReader::step_of(const ChipReading& reading) const {
  return reading.ticks > 0 && units_.tick > Duration::zero() ? reading.ticks * units_.tick : units_.period;
}

void ChipReader::feed(ByteView bytes, MonotonicTime received, SampleSink& sink) {
  polled_.clear();
  blocks_.feed(bytes, [this](std::uint8_t tag, ByteView payload) { decoder_->feed(tag, payload, *this); });
  // How long before the last reading each was made: the steps of those after it.
  Duration after{};
  for (const auto& reading : polled_) after += step_of(reading);
  for (const auto& reading : polled_) {
    const Duration step = step_of(reading);
    after -= step;
    Sample sample = sample_of(reading, units_);
    sample.captured = received - after;
    sink.on_sample(sample, is_first_ ? Duration{} : step);
    is_first_ = false;
    ++samples_;
  }
}

void ChipReader::restart() {
  blocks_.restart();
  decoder_->restart();
  is_first_ = true;
}

DeviceReader::Counters ChipReader::counters() const {
  const auto& chip = decoder_->stats();
  return {.bytes = blocks_.stats().bytes,
          .frames = blocks_.stats().blocks,
          .bad_checksums = 0,
          .skipped_bytes = blocks_.stats().skipped_bytes + chip.skipped_bytes,
          .samples = samples_,
          .incomplete = chip.overflows + lost_ + asleep_,
          .foreign_frames = 0};
}

}  // namespace nacelle::imu
