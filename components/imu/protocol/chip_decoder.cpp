// SPDX-License-Identifier: Apache-2.0
#include "imu/protocol/chip_decoder.hpp"

#include <algorithm>

#include "imu/protocol/block_decoder.hpp"

namespace nacelle::imu {
namespace {

std::int16_t load_be16s(const std::uint8_t* at) { return static_cast<std::int16_t>(at[0] << 8 | at[1]); }

Counts load_be(const std::uint8_t* at) { return {load_be16s(at), load_be16s(at + 2), load_be16s(at + 4)}; }
Counts load_le(const std::uint8_t* at) { return {load_le16s(at), load_le16s(at + 2), load_le16s(at + 4)}; }

// AK8963 from 02: ST1 (bit 0: new), x y z, ST2 (bit 3: overflow). AK09916 from 10: the same with an unused byte before ST2.
// Source: AK8963 and AK09916 data sheets, register tables.
std::optional<Counts> field_of_asahi(ByteView bytes) {
  const bool is_new = (bytes.front() & 0x01U) != 0, overflowed = (bytes.back() & 0x08U) != 0;
  if (!is_new || overflowed) return std::nullopt;
  return load_le(bytes.data() + 1);
}

}  // namespace

void ChipDecoder::feed(std::uint8_t tag, ByteView payload, ReadingSink& sink) {
  stats_.bytes += payload.size();
  if ((tag & block_layout::kOverflowBit) != 0) {
    ++stats_.overflows;
    stats_.skipped_bytes += payload.size();
    return;
  }
  const std::size_t used = decode(static_cast<BlockTag>(tag), payload, sink);
  stats_.used_bytes += used;
  stats_.skipped_bytes += payload.size() - used;
}

void ChipDecoder::emit(ReadingSink& sink) {
  ++stats_.readings;
  sink.on_reading(pending_);
  pending_.field.reset();
  pending_.temperature.reset();
  pending_.ticks = 0;
}

std::size_t InvensenseDecoder::decode(BlockTag tag, ByteView payload, ReadingSink& sink) {
  if (tag == BlockTag::Field) {
    const std::size_t expected = compass_ == Compass::Ak8963 ? 8 : compass_ == Compass::Ak09916 ? 9 : 0;
    if (expected == 0 || payload.size() != expected) return 0;
    const auto field = field_of_asahi(payload);
    if (!field) return 0;
    pending_.field = field;
    return expected;
  }
  if (tag != BlockTag::Record) return 0;
  std::size_t used = 0;
  for (; payload.size() - used >= kRecordBytes; used += kRecordBytes) {
    const std::uint8_t* const at = payload.data() + used;
    pending_.acceleration = load_be(at);
    pending_.angular_velocity = load_be(at + (temperature_last_ ? 6 : 8));
    pending_.temperature = load_be16s(at + (temperature_last_ ? 12 : 6));
    emit(sink);
  }
  return used;
}

void Lsm6dsoxDecoder::restart() {
  ChipDecoder::restart();
  slot_ = 0xFF;
  has_acceleration_ = has_rate_ = false;
  last_time_.reset();
  since_last_time_ = 0;
}

bool Lsm6dsoxDecoder::take_word(const std::uint8_t* word, ReadingSink& sink) {
  const unsigned sensor = word[0] >> 3U;
  const auto slot = static_cast<std::uint8_t>(word[0] >> 1U & 3U);
  if (sensor != 1 && sensor != 2 && sensor != 4) return false;
  if (slot != slot_) {
    // Half a slot is never joined with half of another.
    slot_ = slot;
    has_acceleration_ = has_rate_ = false;
  }
  if (sensor == 4) {
    const std::uint32_t time = load_le16(word + 1) | static_cast<std::uint32_t>(load_le16(word + 3)) << 16U;
    // Unsigned: the counter may wrap (after 29 hours).
    if (last_time_) since_last_time_ = time - *last_time_;
    last_time_ = time;
  }
  if (sensor == 2) {
    pending_.acceleration = load_le(word + 1);
    has_acceleration_ = true;
  }
  if (sensor == 1) {
    pending_.angular_velocity = load_le(word + 1);
    has_rate_ = true;
  }
  if (!has_acceleration_ || !has_rate_) return true;
  has_acceleration_ = has_rate_ = false;
  pending_.ticks = since_last_time_;
  emit(sink);
  return true;
}

std::size_t Lsm6dsoxDecoder::decode(BlockTag tag, ByteView payload, ReadingSink& sink) {
  if (tag == BlockTag::Field) {
    if (payload.size() != kFieldBytes || (payload[0] & 0x08U) == 0) return 0;
    pending_.field = load_le(payload.data() + 1);
    return kFieldBytes;
  }
  if (tag == BlockTag::Temperature) {
    if (payload.size() != 2) return 0;
    pending_.temperature = load_le16s(payload.data());
    return 2;
  }
  if (tag != BlockTag::Record) return 0;
  std::size_t used = 0;
  if (!fifo_) {
    if (payload.size() != kRecordBytes) return 0;
    pending_.temperature = load_le16s(payload.data());
    pending_.angular_velocity = load_le(payload.data() + 2);
    pending_.acceleration = load_le(payload.data() + 8);
    emit(sink);
    return kRecordBytes;
  }
  for (std::size_t at = 0; payload.size() - at >= kWordBytes; at += kWordBytes) {
    if (take_word(payload.data() + at, sink)) used += kWordBytes;
  }
  return used;
}

void Bmi088Decoder::restart() {
  ChipDecoder::restart();
  has_acceleration_ = false;
  polled_count_ = 0;
}

std::size_t Bmi088Decoder::take_accelerations(ByteView payload) {
  std::size_t used = 0;
  polled_count_ = 0;
  while (used < payload.size()) {
    const std::size_t left = payload.size() - used;
    // The two lowest bits of a data frame's header tell of the interrupt pins.
    const auto header = static_cast<std::uint8_t>(payload[used] & 0xFCU);
    const std::size_t length = header == 0x84                                       ? 7
                               : header == 0x44                                     ? 4
                               : header == 0x40 || header == 0x48 || header == 0x50 ? 2
                                                                                    : 0;
    // Past its end the FIFO reads 80; anything else unknown has no length that could be skipped.
    if (length == 0 || length > left) return used;
    if (header == 0x84) {
      if (polled_count_ == polled_.size()) return used;
      polled_[polled_count_++] = load_le(payload.data() + used + 1);
      has_acceleration_ = true;
    }
    used += length;
  }
  return used;
}

std::size_t Bmi088Decoder::decode(BlockTag tag, ByteView payload, ReadingSink& sink) {
  if (tag == BlockTag::Acceleration) return take_accelerations(payload);
  if (tag == BlockTag::Direct) {
    if (payload.size() != kFrameBytes) return 0;
    polled_[0] = load_le(payload.data());
    polled_count_ = 1;
    has_acceleration_ = true;
    return kFrameBytes;
  }
  if (tag == BlockTag::Temperature) {
    if (payload.size() != 2) return 0;
    const int value = payload[0] << 3 | payload[1] >> 5;
    pending_.temperature = static_cast<std::int16_t>(value > 1023 ? value - 2048 : value);
    return 2;
  }
  // Without an acceleration a gyro frame is no reading yet.
  if (tag != BlockTag::Record || !has_acceleration_) return 0;
  std::size_t used = 0;
  for (; payload.size() - used >= kFrameBytes; used += kFrameBytes) {
    const std::size_t after = payload.size() / kFrameBytes - used / kFrameBytes - 1;
    if (polled_count_ > 0) pending_.acceleration = polled_[polled_count_ - 1 - std::min(after, polled_count_ - 1)];
    pending_.angular_velocity = load_le(payload.data() + used);
    emit(sink);
  }
  polled_count_ = 0;
  return used;
}

std::size_t Bno055Decoder::decode(BlockTag tag, ByteView payload, ReadingSink& sink) {
  if (tag != BlockTag::Record || payload.size() != kRecordBytes) return 0;
  const std::uint8_t* const at = payload.data();
  pending_.acceleration = load_le(at);
  pending_.angular_velocity = load_le(at + 0x14 - kFirstRegister);
  const Counts field = load_le(at + 0x0E - kFirstRegister);
  // All zeros: the magnetometer is off (mode IMU) or has not measured yet. The same for the quaternion.
  if (field != Counts{}) pending_.field = field;
  std::array<std::int16_t, 4> q{};
  for (std::size_t i = 0; i < 4; ++i) q[i] = load_le16s(at + 0x20 - kFirstRegister + 2 * i);
  pending_.quaternion.reset();
  if (q != std::array<std::int16_t, 4>{}) pending_.quaternion = q;
  pending_.temperature = static_cast<std::int8_t>(at[0x34 - kFirstRegister]);
  emit(sink);
  return kRecordBytes;
}

}  // namespace nacelle::imu
