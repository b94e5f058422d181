// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/waveshare_feedback.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diff_drive/protocol/flat_json.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr double kBaseFeedbackType = 1001.0;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// The fields that matter, as they stand in the line.
struct RawFields {
  std::optional<double> type, left, right, left_travel, right_travel, voltage, roll_deg, pitch_deg, yaw_deg, mag_x;

  std::optional<double>* find(std::string_view key) {
    struct Entry {
      std::string_view key;
      std::optional<double> RawFields::*field;
    };
    static constexpr Entry kEntries[] = {
        {"T", &RawFields::type},          {"L", &RawFields::left},           {"R", &RawFields::right},
        {"odl", &RawFields::left_travel}, {"odr", &RawFields::right_travel}, {"v", &RawFields::voltage},
        {"r", &RawFields::roll_deg},      {"p", &RawFields::pitch_deg},      {"y", &RawFields::yaw_deg},
        {"mx", &RawFields::mag_x},
    };
    for (const Entry& entry : kEntries) {
      if (entry.key == key) return &(this->*entry.field);
    }
    return nullptr;
  }
};

// A flipped bit must not become a jump of the odometry by the width of a continent.
constexpr double kPlausibleSpeed_mps = 100.0;
constexpr double kPlausibleTravel_m = 1e7;

bool is_plausible(const BaseFeedback& feedback) {
  return std::abs(feedback.left_mps) <= kPlausibleSpeed_mps && std::abs(feedback.right_mps) <= kPlausibleSpeed_mps &&
         std::abs(feedback.left_travel_m.value_or(0.0)) <= kPlausibleTravel_m &&
         std::abs(feedback.right_travel_m.value_or(0.0)) <= kPlausibleTravel_m;
}

std::optional<double> times(const std::optional<double>& value, double factor) {
  return value ? std::optional<double>{*value * factor} : std::nullopt;
}

}  // namespace

Result<BaseFeedback, LineFault> decode_base_feedback(std::string_view line) {
  RawFields raw;
  FlatJsonReader json{line};
  while (const auto member = json.next()) {
    if (auto* field = raw.find(member->key)) *field = member->number;
  }
  if (json.failed() || !raw.type) return err(LineFault::Malformed);
  if (*raw.type != kBaseFeedbackType) return err(LineFault::OtherType);
  if (!raw.left || !raw.right) return err(LineFault::Malformed);

  const bool raw_integers = raw.mag_x.has_value();
  const bool has_travel = raw.left_travel && raw.right_travel;
  BaseFeedback feedback;
  feedback.left_mps = *raw.left;
  feedback.right_mps = *raw.right;
  if (has_travel) {
    const double metres = raw_integers ? 0.01 : 1.0;
    feedback.left_travel_m = times(raw.left_travel, metres);
    feedback.right_travel_m = times(raw.right_travel, metres);
  }
  feedback.voltage_v = times(raw.voltage, raw_integers ? 0.01 : 1.0);
  feedback.roll_rad = times(raw.roll_deg, kRadPerDeg);
  feedback.pitch_rad = times(raw.pitch_deg, kRadPerDeg);
  // The oldest firmware has no travel, and its y is a coordinate of the arm.
  if (has_travel) feedback.yaw_rad = times(raw.yaw_deg, kRadPerDeg);
  if (!is_plausible(feedback)) return err(LineFault::Malformed);
  return feedback;
}

void WaveshareLineDecoder::restart() {
  stats_.malformed_bytes += pending_;
  if (pending_ != 0) ++stats_.malformed_lines;
  pending_ = 0;
}

std::optional<BaseFeedback> WaveshareLineDecoder::take_line(ByteView& bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), static_cast<std::uint8_t>('\n'));
  const auto part = static_cast<std::size_t>(end - bytes.begin());
  const bool ends = end != bytes.end();
  const std::size_t taken = part + (ends ? 1 : 0);

  if (pending_ + part <= kMaxLineBytes)
    std::copy_n(bytes.begin(), part, line_.begin() + static_cast<std::ptrdiff_t>(pending_));
  stats_.bytes += taken;
  pending_ += part;
  bytes = bytes.subspan(taken);
  if (!ends) return std::nullopt;

  const std::size_t line_bytes = pending_ + 1;
  const std::size_t length = pending_;
  pending_ = 0;
  if (length > kMaxLineBytes) {
    ++stats_.overlong_lines;
    stats_.overlong_bytes += line_bytes;
    return std::nullopt;
  }
  return finish_line({line_.data(), length}, line_bytes);
}

std::optional<BaseFeedback> WaveshareLineDecoder::finish_line(std::string_view line, std::size_t line_bytes) {
  if (line.find_first_not_of("\r \t") == std::string_view::npos) {
    stats_.blank_bytes += line_bytes;
    return std::nullopt;
  }
  const auto feedback = decode_base_feedback(line);
  if (feedback) {
    ++stats_.feedback_lines;
    stats_.feedback_bytes += line_bytes;
    return feedback.value();
  }
  if (feedback.error() == LineFault::OtherType) {
    ++stats_.other_lines;
    stats_.other_bytes += line_bytes;
  } else {
    ++stats_.malformed_lines;
    stats_.malformed_bytes += line_bytes;
  }
  return std::nullopt;
}

}  // namespace nacelle::diff_drive
