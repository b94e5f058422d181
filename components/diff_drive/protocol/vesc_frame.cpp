// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/vesc_frame.hpp"

#include <algorithm>

#include "diff_drive/protocol/big_endian.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr std::uint8_t kStart = 0x02, kEnd = 0x03;
constexpr std::uint8_t kSetDuty = 5, kSetSpeed = 8, kForward = 34, kGetSelected = 50;

// Bits of the mask, and bytes of their values in the answer. Source: commands.c, COMM_GET_VALUES_SELECTIVE.
enum : unsigned { kErpmBit = 7, kVoltageBit = 8, kTachometerBit = 13, kFaultBit = 15, kIdBit = 17 };
constexpr std::uint8_t kValueBytes[] = {2, 2, 4, 4, 4, 4, 2, 4, 2, 4, 4, 4, 4, 4, 4, 1, 4, 1, 6};
constexpr std::uint32_t kMask =
    (1U << kErpmBit) | (1U << kVoltageBit) | (1U << kTachometerBit) | (1U << kFaultBit) | (1U << kIdBit);

struct FaultName {
  const char* left;
  const char* right;
};
// Source: mc_fault_code in datatypes.h.
constexpr FaultName kFaults[] = {
    {"left VESC: voltage too high", "right VESC: voltage too high"},
    {"left VESC: voltage too low", "right VESC: voltage too low"},
    {"left VESC: gate driver (DRV)", "right VESC: gate driver (DRV)"},
    {"left VESC: absolute over-current", "right VESC: absolute over-current"},
    {"left VESC: transistors too hot", "right VESC: transistors too hot"},
    {"left VESC: motor too hot", "right VESC: motor too hot"},
    {"left VESC: gate driver's voltage too high", "right VESC: gate driver's voltage too high"},
    {"left VESC: gate driver's voltage too low", "right VESC: gate driver's voltage too low"},
    {"left VESC: processor's voltage too low", "right VESC: processor's voltage too low"},
    {"left VESC: it restarted by its own watchdog", "right VESC: it restarted by its own watchdog"},
    {"left VESC: encoder (SPI)", "right VESC: encoder (SPI)"},
};
constexpr FaultName kOtherFault{"left VESC: a fault that `faults` in VESC Tool's terminal names",
                                "right VESC: a fault that `faults` in VESC Tool's terminal names"};

}  // namespace

void VescPrinter::add(int id, std::uint8_t command, std::uint32_t data) {
  std::uint8_t* const frame = bytes_.data() + size_;
  std::size_t payload = 0;
  if (id != kOnTheLine) {
    frame[2] = kForward;
    frame[3] = static_cast<std::uint8_t>(id);
    payload = 2;
  }
  frame[2 + payload] = command;
  store_be32(frame + 3 + payload, data);
  payload += 5;
  frame[0] = kStart;
  frame[1] = static_cast<std::uint8_t>(payload);
  store_be16(frame + 2 + payload, crc16_xmodem({frame + 2, payload}));
  frame[4 + payload] = kEnd;
  size_ += payload + 5;
}

ByteView VescPrinter::speeds(std::int32_t left_erpm, std::int32_t right_erpm) {
  size_ = 0;
  add(ids_[0], kSetSpeed, static_cast<std::uint32_t>(left_erpm));
  add(ids_[1], kSetSpeed, static_cast<std::uint32_t>(right_erpm));
  return {bytes_.data(), size_};
}

ByteView VescPrinter::zero_duties() {
  size_ = 0;
  for (const int id : ids_) add(id, kSetDuty, 0);
  return {bytes_.data(), size_};
}

ByteView VescPrinter::get_values() {
  size_ = 0;
  for (const int id : ids_) add(id, kGetSelected, kMask);
  return {bytes_.data(), size_};
}

std::optional<VescValues> decode_vesc_values(ByteView payload) {
  if (payload.size() < 5 || payload[0] != kGetSelected) return std::nullopt;
  const std::uint32_t mask = load_be32(payload.data() + 1);
  if ((mask & kMask) != kMask) return std::nullopt;
  VescValues values;
  std::size_t at = 5;
  for (unsigned bit = 0; bit <= kIdBit; ++bit) {
    if ((mask & (1U << bit)) == 0) continue;
    if (at + kValueBytes[bit] > payload.size()) return std::nullopt;
    const std::uint8_t* const value = payload.data() + at;
    switch (bit) {
      case kErpmBit: values.erpm = static_cast<std::int32_t>(load_be32(value)); break;
      case kVoltageBit: values.voltage_v = 0.1 * static_cast<std::int16_t>(load_be16(value)); break;
      case kTachometerBit: values.tachometer = static_cast<std::int32_t>(load_be32(value)); break;
      case kFaultBit: values.fault = *value; break;
      case kIdBit: values.id = *value; break;
      default: break;
    }
    at += kValueBytes[bit];
  }
  return values;
}

const char* vesc_fault(std::uint8_t code, bool is_left) {
  if (code == 0) return nullptr;
  const FaultName& name = code <= std::size(kFaults) ? kFaults[code - 1] : kOtherFault;
  return is_left ? name.left : name.right;
}

void VescDecoder::restart() {
  stats_.lost_bytes += pending_;
  pending_ = 0;
}

void VescDecoder::drop(std::size_t count) {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
            buffer_.begin() + static_cast<std::ptrdiff_t>(pending_), buffer_.begin());
  pending_ -= count;
}

std::optional<VescDecoder::Step> VescDecoder::next_frame() {
  if (pending_ == 0) return std::nullopt;
  bool begins_frame = buffer_[0] == kStart;
  if (begins_frame) {
    if (pending_ < 2) return std::nullopt;
    const std::size_t payload = buffer_[1];
    begins_frame = payload != 0 && payload <= kMaxPayload;
    if (begins_frame) {
      const std::size_t length = payload + 5;
      if (pending_ < length) return std::nullopt;
      const ByteView content{buffer_.data() + 2, payload};
      if (buffer_[length - 1] == kEnd && crc16_xmodem(content) == load_be16(buffer_.data() + 2 + payload)) {
        Step step{decode_vesc_values(content)};
        if (step.values) {
          step.values->first_byte = stats_.bytes - pending_;
          ++stats_.frames;
          stats_.value_bytes += length;
        } else {
          ++stats_.other_frames;
          stats_.other_bytes += length;
        }
        drop(length);
        return step;
      }
      ++stats_.bad_checksums;
    }
  }
  ++stats_.lost_bytes;
  drop(1);
  return Step{};
}

}  // namespace nacelle::diff_drive
