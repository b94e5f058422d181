// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/rplidar_protocol.hpp"

#include <fmt/format.h>

namespace nacelle::lidar {
namespace {

// Requests: A5, command; those with bit 7 set also: length, payload, exclusive or of all bytes before.
// Source: as rplidar_frames.hpp.
constexpr std::uint8_t kStop = 0x25, kReset = 0x40, kScan = 0x20, kInfo = 0x50, kHealth = 0x52, kSampleRate = 0x59,
                       kExpressScan = 0x82, kConfiguration = 0x84, kMotorSpeed = 0xA8, kMotorPwm = 0xF0,
                       kBoardFlags = 0xFF;
// Keys of kConfiguration.
constexpr std::uint8_t kModeCount = 0x70, kModePeriod = 0x71, kModeAnswer = 0x75, kTypicalMode = 0x7C, kModeName = 0x7F;
constexpr std::uint16_t kUsualPwm = 660, kUsualSpeed_rpm = 600;
// Model numbers: the high four bits are the series. Source: the SDK asks the motor's board of series 2 and above, and gives series 6
// and above (S) a speed.
constexpr unsigned kFirstOnBoard = 2, kFirstWithSpeed = 6;
// Firmware since which there is an express scan. Source: the SDK.
constexpr unsigned kFirstExpress = (1U << 8U) | 17U;

constexpr Duration kStreamEnds = 20ms, kAnswerLimit = 300ms, kResetTime = 2s, kFirstPacket = 6s, kDry = 1s,
                   kAskAgain = 5s;
constexpr unsigned kMostTries = 3;

bool same_name(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

std::string_view series_of(unsigned model) {
  switch (model >> 4U) {
    case 1: return "A1";
    case 2: return "A2";
    case 3: return "A3";
    case 4: return "C1";
    case 6: return "S1";
    case 7: return "S2";
    case 8: return "S3";
    default: return "of an unknown series";
  }
}

}  // namespace

void RplidarProtocol::feed(ByteView bytes, SweepSink& sink) {
  decoder_.feed(bytes, [&](const RplidarPacket& packet, std::size_t bytes_after) {
    if (is_stream(packet.type)) {
      heard_ = true;
      sweeps_.take(packet, bytes_after, sink);
    } else if (step_ == Step::Wait) {
      hear(packet);
    }
  });
}

void RplidarProtocol::restart() {
  decoder_.restart();
  sweeps_.restart();
  step_ = Step::Stop;
  was_reset_ = heard_ = false;
  tries_ = 0;
  refusal_.clear();
}

LineStats RplidarProtocol::stats() const {
  LineStats stats = decoder_.stats();
  stats.unpaired = sweeps_.unpaired();
  return stats;
}

LineAction RplidarProtocol::send(std::uint8_t command, std::initializer_list<std::uint8_t> payload) {
  std::size_t length = 0;
  request_[length++] = rplidar_layout::kRequest;
  request_[length++] = command;
  if ((command & 0x80U) != 0) {
    request_[length++] = static_cast<std::uint8_t>(payload.size());
    for (const std::uint8_t byte : payload) request_[length++] = byte;
    std::uint8_t sum = 0;
    for (std::size_t i = 0; i < length; ++i) sum = static_cast<std::uint8_t>(sum ^ request_[i]);
    request_[length++] = sum;
  }
  return {.bytes = ByteView{request_}.first(length), .data_terminal_ready = std::nullopt};
}

LineAction RplidarProtocol::ask() {
  const auto low = static_cast<std::uint8_t>(mode_), high = static_cast<std::uint8_t>(mode_ >> 8U);
  switch (question_) {
    case Question::Info: decoder_.expect(RplidarAnswer::Info); return send(kInfo);
    case Question::Health: decoder_.expect(RplidarAnswer::Health); return send(kHealth);
    case Question::SampleRate: decoder_.expect(RplidarAnswer::SampleRate); return send(kSampleRate);
    case Question::BoardFlags: decoder_.expect(RplidarAnswer::BoardFlags); return send(kBoardFlags, {0, 0, 0, 0});
    default: break;
  }
  decoder_.expect(RplidarAnswer::Configuration);
  switch (question_) {
    case Question::ModeCount: return send(kConfiguration, {kModeCount, 0, 0, 0});
    case Question::ModeName: return send(kConfiguration, {kModeName, 0, 0, 0, low, high});
    case Question::ModeAnswer: return send(kConfiguration, {kModeAnswer, 0, 0, 0, low, high});
    case Question::ModePeriod: return send(kConfiguration, {kModePeriod, 0, 0, 0, low, high});
    default: return send(kConfiguration, {kTypicalMode, 0, 0, 0});
  }
}

void RplidarProtocol::ask_next(Question question) {
  question_ = question;
  tries_ = 0;
  step_ = Step::Ask;
}

void RplidarProtocol::refuse(std::string why) {
  refusal_ = std::move(why);
  step_ = Step::Refused;
  until_ = {};
}

void RplidarProtocol::hear(const RplidarPacket& answer) {
  const std::uint8_t* const at = answer.bytes.data();
  switch (answer.type) {
    case RplidarAnswer::Info:
      model_ = at[0];
      firmware_ = load_le16(at + 1);
      hardware_ = at[3];
      serial_ = to_hex(answer.bytes.subspan(4));
      return ask_next(Question::Health);
    case RplidarAnswer::Health:
      if (at[0] == 2) {
        if (!std::exchange(was_reset_, true)) {
          step_ = Step::Halt;  // which sees that it is to be reset
          return;
        }
        return refuse(fmt::format("the LiDAR protects itself: health is error, code {}", load_le16(at + 1)));
      }
      was_reset_ = false;
      return ask_next(scan_mode_.empty() ? Question::TypicalMode : Question::ModeCount);
    case RplidarAnswer::SampleRate:
      period_us_ = load_le16(at + (stream_ == RplidarAnswer::Nodes ? 0 : 2));
      return ask_for_motor();
    case RplidarAnswer::BoardFlags:
      if ((load_le32(at) & 1U) != 0) motor_ = Motor::ByPwm;
      return finish_identification();
    case RplidarAnswer::Configuration: return hear_configuration(answer.bytes);
    default: return;
  }
}

void RplidarProtocol::hear_configuration(ByteView answer) {
  const std::uint32_t key = load_le32(answer.data());
  const ByteView value = answer.subspan(4);
  const auto number = [&](std::size_t bytes) {
    std::uint32_t sum = 0;
    for (std::size_t i = std::min(bytes, value.size()); i > 0; --i) sum = sum << 8U | value[i - 1];
    return sum;
  };
  if (question_ == Question::TypicalMode && key == kTypicalMode) {
    mode_ = static_cast<std::uint16_t>(number(2));
    return ask_next(Question::ModeName);
  }
  if (question_ == Question::ModeCount && key == kModeCount) {
    mode_count_ = static_cast<std::uint16_t>(std::min<std::uint32_t>(number(2), 32));
    mode_ = 0;
    mode_names_.clear();
    if (mode_count_ > 0) return ask_next(Question::ModeName);
    return choose_old_mode();
  }
  if (question_ == Question::ModeName && key == kModeName) {
    const std::string_view text = as_text(value);
    mode_name_ = text.substr(0, text.find('\0'));
    if (scan_mode_.empty() || same_name(mode_name_, scan_mode_)) return ask_next(Question::ModeAnswer);
    mode_names_.push_back(mode_name_);
    if (++mode_ < mode_count_) return ask_next(Question::ModeName);
    return refuse(fmt::format("scan_mode '{}' is none of the LiDAR's: {}", scan_mode_, fmt::join(mode_names_, ", ")));
  }
  if (question_ == Question::ModeAnswer && key == kModeAnswer) {
    stream_ = static_cast<RplidarAnswer>(number(1));
    if (is_stream(stream_)) return ask_next(Question::ModePeriod);
    return refuse(
        fmt::format("scan mode {} ({}) has packets of type {:02x}, which Nacelle does not read; set scan_mode: "
                    "Standard",
                    mode_, mode_name_, number(1)));
  }
  if (question_ == Question::ModePeriod && key == kModePeriod) {
    period_us_ = number(4) / 256.0;
    return ask_for_motor();
  }
}

/// Firmware without scan modes: there are two.
void RplidarProtocol::choose_old_mode() {
  const bool has_express = firmware_ >= kFirstExpress;
  const bool wants_express = scan_mode_.empty() ? has_express : same_name(scan_mode_, "Express");
  if (!scan_mode_.empty() && !(wants_express && has_express) && !same_name(scan_mode_, "Standard")) {
    return refuse(
        fmt::format("scan_mode '{}' is none of the LiDAR's: Standard{}", scan_mode_, has_express ? ", Express" : ""));
  }
  mode_ = 0;
  stream_ = wants_express ? RplidarAnswer::Capsules : RplidarAnswer::Nodes;
  mode_name_ = wants_express ? "Express" : "Standard";
  ask_next(Question::SampleRate);
}

void RplidarProtocol::ask_for_motor() {
  const unsigned series = model_ >> 4U;
  motor_ = series >= kFirstWithSpeed ? Motor::BySpeed : Motor::ByModemLine;
  if (series < kFirstOnBoard || series >= kFirstWithSpeed) return finish_identification();
  ask_next(Question::BoardFlags);
}

void RplidarProtocol::finish_identification() {
  if (!(period_us_ >= 1.0 && period_us_ <= 100'000.0))
    return refuse(fmt::format("the LiDAR says that a sample takes {} us", period_us_));
  sweeps_.begin(from_seconds(period_us_ * 1e-6));
  refusal_.clear();
  identity_ = fmt::format(
      "RPLIDAR {} (model {:02x}), firmware {}.{:02}, hardware {}, serial number {}, scan mode {} at {:.0f} "
      "points/s",
      series_of(model_), model_, firmware_ >> 8U, firmware_ & 0xFFU, hardware_, serial_, mode_name_, 1e6 / period_us_);
  step_ = wanted_ ? Step::Idle : Step::HaltMotor;
}

void RplidarProtocol::give_up_question() {
  switch (question_) {
    case Question::TypicalMode:
    case Question::ModeCount: return choose_old_mode();
    case Question::ModeName: mode_name_ = fmt::format("{}", mode_); return ask_next(Question::ModeAnswer);
    case Question::SampleRate: period_us_ = stream_ == RplidarAnswer::Nodes ? 500.0 : 250.0; return ask_for_motor();
    case Question::BoardFlags: return finish_identification();
    default: step_ = Step::Stop; return;  // it must answer the others: all over again
  }
}

LineAction RplidarProtocol::drive_motor(bool on) {
  motor_runs_ = on;
  if (motor_ == Motor::ByModemLine)
    return {.bytes = {}, .data_terminal_ready = !on};  // the A1's motor runs while DTR is off
  const std::uint16_t value = !on ? 0 : motor_ == Motor::ByPwm ? kUsualPwm : kUsualSpeed_rpm;
  return send(motor_ == Motor::ByPwm ? kMotorPwm : kMotorSpeed,
              {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8U)});
}

std::optional<LineAction> RplidarProtocol::next_action(MonotonicTime now) {
  const bool heard = std::exchange(heard_, false);
  // Whatever is under way, also a new identification: a motor that turns is stopped first.
  const bool runs = step_ == Step::Scan || step_ == Step::Starting || step_ == Step::Measuring || motor_runs_;
  if (runs && !wanted_ && step_ != Step::HaltMotor) step_ = Step::Halt;
  switch (step_) {
    case Step::Stop:
      decoder_.expect(RplidarAnswer::None);
      step_ = Step::Pause;
      pause(now, kStreamEnds);
      return send(kStop);
    case Step::Pause:
      if (now < until_) return std::nullopt;
      ask_next(Question::Info);
      [[fallthrough]];
    case Step::Ask:
      ++tries_;
      step_ = Step::Wait;
      pause(now, kAnswerLimit);
      return ask();
    case Step::Wait:
      if (now < until_) return std::nullopt;
      if (tries_ < kMostTries) {
        step_ = Step::Ask;
      } else {
        give_up_question();
      }
      return next_action(now);
    case Step::Idle:
      if (!wanted_) return std::nullopt;
      step_ = Step::Scan;
      return drive_motor(true);
    case Step::Scan:
      decoder_.expect(stream_);
      sweeps_.restart();
      step_ = Step::Starting;
      pause(now, kFirstPacket);
      if (stream_ == RplidarAnswer::Nodes) return send(kScan);
      return send(kExpressScan, {static_cast<std::uint8_t>(mode_), 0, 0, 0, 0});
    case Step::Starting:
    case Step::Measuring:
      if (heard) {
        step_ = Step::Measuring;
        pause(now, kDry);
      }
      if (now < until_) return std::nullopt;
      step_ = Step::Stop;
      return next_action(now);
    case Step::Halt:
      decoder_.expect(RplidarAnswer::None);
      sweeps_.restart();
      if (was_reset_) {
        step_ = Step::Pause;
        motor_runs_ = false;
        pause(now, kResetTime);
        return send(kReset);
      }
      step_ = Step::HaltMotor;
      return send(kStop);
    case Step::HaltMotor: step_ = Step::Idle; return drive_motor(false);
    case Step::Refused:
      if (until_ == MonotonicTime{}) pause(now, kAskAgain);
      if (now < until_) return std::nullopt;
      was_reset_ = false;
      step_ = Step::Stop;
      return next_action(now);
  }
  return std::nullopt;
}

}  // namespace nacelle::lidar
