// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/ydlidar_protocol.hpp"

#include <fmt/format.h>

#include <cmath>

namespace nacelle::lidar {
namespace {

// Requests are A5 and one of these. Source: as ydlidar_decoder.hpp.
constexpr std::uint8_t kScanRequest = 0x60, kStopRequest = 0x65, kInfoRequest = 0x90, kHealthRequest = 0x91;

constexpr Duration kRestOfStream = 50ms, kAnswerTime = 500ms, kFirstPacketTime = 6s, kSilent = 1s, kRefusedTime = 5s;

}  // namespace

YdlidarProtocol::YdlidarProtocol(const Settings& settings)
    : period_(Duration{1'000'000'000LL / static_cast<std::int64_t>(settings.points_per_second)}),
      has_intensities_(settings.has_intensities),
      is_commanded_(settings.is_commanded),
      packets_(settings.has_intensities) {}

void YdlidarProtocol::feed(ByteView bytes, SweepSink& sink) {
  if (is_commanded_ && step_ != Step::Running) {
    answers_.feed(bytes, [this](const RplidarPacket& answer, std::size_t) { hear(answer); });
    return;
  }
  packets_.feed(bytes,
                [&](const YdlidarPacket& packet, std::size_t bytes_after) { measure(packet, bytes_after, sink); });
}

void YdlidarProtocol::measure(const YdlidarPacket& packet, std::size_t bytes_after, SweepSink& sink) {
  heard_ = true;
  const auto count = static_cast<std::int64_t>(packet.count);
  double span_deg = packet.last_deg - packet.first_deg;
  if (span_deg < 0.0) span_deg += 360.0;
  const double step_deg = count > 1 ? span_deg / static_cast<double>(count - 1) : 0.0;
  for (std::size_t i = 0; i < packet.count; ++i) {
    const std::uint8_t* const at = packet.samples.data() + i * (has_intensities_ ? 3 : 2);
    double range_mm = load_le16(at) / 4.0;
    float intensity = 0.0F;
    if (has_intensities_) {
      intensity = static_cast<float>(at[0] | (at[1] & 3U) << 8U);
      range_mm = load_le16(at + 1) >> 2U;
    }
    double angle_deg =
        std::fmod(packet.first_deg + static_cast<double>(i) * step_deg + ydlidar_correction_deg(range_mm), 360.0);
    if (angle_deg < 0.0) angle_deg += 360.0;
    beams_[i] = {static_cast<float>(angle_deg), static_cast<float>(range_mm / 1000.0), intensity};
  }
  const std::span<const Beam> beams{beams_.data(), packet.count};
  // A packet that claims more than half a turn has wrong angles, a single sample says nothing about the speed.
  const double step_before_deg = step_deg_;
  if (span_deg < 180.0 && count > 8) {
    step_deg_ = step_deg;
    offset_.learn(beams, packet.first_deg, step_deg);
  }
  std::int64_t steps = count;
  if (packet.skipped_bytes > 0 && step_before_deg > 1e-3 && last_deg_ >= 0.0) {
    // The rotor says how many samples were lost. Between two packets its speed changes evenly: its mean counts.
    double turned_deg = std::fmod(packet.first_deg - last_deg_ + 360.0, 360.0);
    if (turned_deg > 359.0) turned_deg = 0.0;  // a step back is noise
    const double mean_step_deg = (step_before_deg + step_deg_) / 2.0;
    steps = std::max(count, count - 1 + static_cast<std::int64_t>(std::llround(turned_deg / mean_step_deg)));
  }
  sink.on_sweep({.beams = beams,
                 .first_rotor_deg = offset_.seen_from(packet.first_deg),
                 .rotor_step_deg = step_deg,
                 .period = period_,
                 .since_last = last_deg_ < 0.0 ? Duration{} : steps * period_,
                 .packet_bytes = packet.bytes,
                 .speed_dps = step_deg_ / to_seconds(period_),
                 .has_intensities = has_intensities_},
                bytes_after);
  last_deg_ = packet.last_deg;
}

void YdlidarProtocol::restart() {
  packets_.restart();
  answers_.restart();
  last_deg_ = -1.0;
  step_ = Step::Stop;
  heard_ = measures_ = false;
  refusal_.clear();
}

LineStats YdlidarProtocol::stats() const {
  LineStats stats = packets_.stats();
  const LineStats& answers = answers_.stats();
  stats.bytes += answers.bytes;
  stats.framed_bytes += answers.framed_bytes;
  stats.bad_checksums += answers.bad_checksums;
  stats.skipped_bytes += answers.skipped_bytes;
  return stats;
}

bool YdlidarProtocol::is_settled() const {
  if (!is_commanded_) return packets_.stats().frames > 0;
  return wanted_ ? measures_ : step_ == Step::Idle;
}

LineAction YdlidarProtocol::send(std::uint8_t command) {
  request_ = {rplidar_layout::kRequest, command};
  return {.bytes = ByteView{request_}, .data_terminal_ready = std::nullopt};
}

void YdlidarProtocol::hear(const RplidarPacket& answer) {
  const std::uint8_t* const at = answer.bytes.data();
  if (answer.type == RplidarAnswer::Info && step_ == Step::Info) {
    identity_ = fmt::format("YDLIDAR (model {}), firmware {}.{}, hardware {}, serial number {}", at[0], at[2], at[1],
                            at[3], to_hex(answer.bytes.subspan(4)));
    step_ = Step::Health;
    until_ = {};
  } else if (answer.type == RplidarAnswer::Health && step_ == Step::Health) {
    refusal_.clear();
    if (at[0] == 2) {
      refusal_ = fmt::format("the LiDAR protects itself: health is error, code {}", load_le16(at + 1));
      step_ = Step::Refused;
      until_ = {};
    } else {
      step_ = wanted_ ? Step::Idle : Step::HaltMotor;
    }
  }
}

std::optional<LineAction> YdlidarProtocol::next_action(MonotonicTime now) {
  if (!is_commanded_) return std::nullopt;
  // Whatever is under way, also a new identification: a motor that turns is stopped first.
  if ((step_ == Step::Scan || step_ == Step::Running || motor_runs_) && !wanted_ && step_ != Step::HaltMotor) {
    packets_.restart();
    last_deg_ = -1.0;
    measures_ = false;
    step_ = Step::HaltMotor;
    return send(kStopRequest);
  }
  switch (step_) {
    case Step::Stop:
      answers_.expect(RplidarAnswer::None);
      step_ = Step::Pause;
      until_ = now + kRestOfStream;
      return send(kStopRequest);
    case Step::Pause:
      if (now < until_) return std::nullopt;
      answers_.expect(RplidarAnswer::Info);
      step_ = Step::Info;
      until_ = now + kAnswerTime;
      return send(kInfoRequest);
    case Step::Info:
    case Step::Health:
      if (step_ == Step::Health && until_ == MonotonicTime{}) {
        answers_.expect(RplidarAnswer::Health);
        until_ = now + kAnswerTime;
        return send(kHealthRequest);
      }
      if (now < until_) return std::nullopt;
      step_ = Step::Stop;
      return next_action(now);
    case Step::Idle:
      if (!wanted_) return std::nullopt;
      step_ = Step::Scan;
      motor_runs_ = true;
      return LineAction{.bytes = {}, .data_terminal_ready = true};
    case Step::Scan:
      answers_.expect(RplidarAnswer::None);
      step_ = Step::Running;
      until_ = now + kFirstPacketTime;
      return send(kScanRequest);
    case Step::Running:
      if (std::exchange(heard_, false)) {
        measures_ = true;
        until_ = now + kSilent;
      }
      if (now < until_) return std::nullopt;
      packets_.restart();
      last_deg_ = -1.0;
      measures_ = false;
      step_ = Step::Stop;
      return next_action(now);
    case Step::HaltMotor:
      step_ = Step::Idle;
      motor_runs_ = false;
      return LineAction{.bytes = {}, .data_terminal_ready = false};
    case Step::Refused:
      if (until_ == MonotonicTime{}) until_ = now + kRefusedTime;
      if (now < until_) return std::nullopt;
      step_ = Step::Stop;
      return next_action(now);
  }
  return std::nullopt;
}

}  // namespace nacelle::lidar
