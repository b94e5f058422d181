// SPDX-License-Identifier: Apache-2.0
#include "motor_firmware.hpp"

#include <string.h>  // NOLINT(modernize-deprecated-headers): avr-gcc has no <cstring>

namespace motor_firmware {
namespace {

const uint8_t kStart = 0xA5;
const float kTurnRad = 6.2831853f;
const float kMostRps = 1000.0f;  // a faster command is a mistake

uint16_t crc16(const uint8_t* bytes, unsigned count) {
  uint16_t crc = 0;
  for (unsigned i = 0; i < count; ++i) {
    crc = static_cast<uint16_t>(crc ^ (bytes[i] << 8));
    for (int bit = 0; bit < 8; ++bit) crc = static_cast<uint16_t>((crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1);
  }
  return crc;
}

// Byte by byte: the firmware runs on machines of either order.
uint32_t load(const uint8_t* at, int bytes) {
  uint32_t value = 0;
  for (int i = bytes - 1; i >= 0; --i) value = (value << 8) | at[i];
  return value;
}
void store(uint8_t* at, uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) at[i] = static_cast<uint8_t>(value >> (8 * i));
}
float load_float(const uint8_t* at) {
  const uint32_t bits = load(at, 4);
  float value = 0;
  memcpy(&value, &bits, sizeof value);
  return value;
}
void store_float(uint8_t* at, float value) {
  uint32_t bits = 0;
  memcpy(&bits, &value, sizeof bits);
  store(at, bits, 4);
}

/// Reads a decimal number and the spaces before it. False: there is none.
bool read_number(const char*& at, float& value) {
  while (*at == ' ') ++at;
  const bool is_negative = *at == '-';
  if (is_negative) ++at;
  bool any = false;
  float number = 0.0f, scale = 1.0f;
  for (; *at >= '0' && *at <= '9'; ++at, any = true) number = number * 10.0f + static_cast<float>(*at - '0');
  if (*at == '.') {
    for (++at; *at >= '0' && *at <= '9'; ++at, any = true) {
      scale *= 0.1f;
      number += scale * static_cast<float>(*at - '0');
    }
  }
  value = is_negative ? -number : number;
  return any;
}

/// Appends text; what does not fit is left out.
struct Text {
  char bytes[80];
  unsigned size = 0;
  void put(char c) {
    if (size < sizeof bytes) bytes[size++] = c;
  }
  void number(int32_t value) {
    uint32_t magnitude = value < 0 ? 0U - static_cast<uint32_t>(value) : static_cast<uint32_t>(value);
    if (value < 0) put('-');
    char digits[10];
    unsigned count = 0;
    do {
      digits[count++] = static_cast<char>('0' + magnitude % 10);
      magnitude /= 10;
    } while (magnitude != 0);
    while (count != 0) put(digits[--count]);
  }
  /// Three decimals.
  void decimal(float value) {
    const float limited = value > 1e6f ? 1e6f : value < -1e6f ? -1e6f : value;
    const int32_t thousandths = static_cast<int32_t>(limited * 1000.0f + (limited < 0.0f ? -0.5f : 0.5f));
    if (thousandths < 0) put('-');
    const int32_t magnitude = thousandths < 0 ? -thousandths : thousandths;
    number(magnitude / 1000);
    put('.');
    put(static_cast<char>('0' + magnitude / 100 % 10));
    put(static_cast<char>('0' + magnitude / 10 % 10));
    put(static_cast<char>('0' + magnitude % 10));
  }
};

float limited(float value, float most) { return value > most ? most : value < -most ? -most : value; }

}  // namespace

MotorFirmware::MotorFirmware(const Hooks& hooks, const Tuning& tuning) : hooks_(hooks), tuning_(tuning) {
  for (int wheel = 0; wheel < 2; ++wheel) counts_[wheel] = hooks_.counts(hooks_.board, wheel);
  stop();
}

void MotorFirmware::stop() {
  for (int wheel = 0; wheel < 2; ++wheel) {
    target_rps_[wheel] = integral_[wheel] = 0.0f;
    hooks_.set_duty(hooks_.board, wheel, 0.0f);
  }
}

void MotorFirmware::command(float left_rps, float right_rps, uint32_t now_ms) {
  // Written so that a NaN is refused, too.
  if (!(left_rps >= -kMostRps && left_rps <= kMostRps && right_rps >= -kMostRps && right_rps <= kMostRps)) return;
  commanded_ms_ = now_ms;
  watchdog_stopped_ = false;
  if (left_rps == 0.0f && right_rps == 0.0f) return stop();
  target_rps_[0] = left_rps;
  target_rps_[1] = right_rps;
}

void MotorFirmware::byte(uint8_t value, uint32_t now_ms) {
  // Text holds no 0xA5, so one begins a frame also behind half a line. Within a frame it may be anything.
  if (frame_size_ == 0 && value != kStart) return text_byte(value, now_ms);
  frame_byte(value, now_ms);
}

void MotorFirmware::frame_byte(uint8_t value, uint32_t now_ms) {
  line_size_ = 0;
  frame_[frame_size_++] = value;
  // A wrong frame is searched for the start of the next one, so that a stop behind half a frame is found.
  for (;;) {
    if (frame_size_ < 3) return;
    const unsigned payload = frame_[2];
    if (payload <= kMaxPayload) {
      const unsigned length = payload + 5;
      if (frame_size_ < length) return;
      if (crc16(frame_ + 1, payload + 2) == load(frame_ + 3 + payload, 2)) {
        obey_frame(now_ms);
        frame_size_ = 0;
        return;
      }
    }
    unsigned next = 1;
    while (next < frame_size_ && frame_[next] != kStart) ++next;
    memmove(frame_, frame_ + next, frame_size_ - next);
    frame_size_ -= next;
  }
}

void MotorFirmware::obey_frame(uint32_t now_ms) {
  speaks_text_ = false;
  const unsigned payload = frame_[2];
  if (frame_[1] == 0x01 && payload == 8) {
    command(load_float(frame_ + 3), load_float(frame_ + 7), now_ms);
  } else if (frame_[1] == 0x02 && payload == 0) {
    command(0.0f, 0.0f, now_ms);
  } else if (frame_[1] == 0x03 && payload == 4) {
    const uint16_t watchdog_ms = static_cast<uint16_t>(load(frame_ + 3, 2));
    const uint16_t period_ms = static_cast<uint16_t>(load(frame_ + 5, 2));
    if (watchdog_ms != 0) watchdog_ms_ = watchdog_ms;
    if (period_ms != 0) period_ms_ = period_ms;
  }
}

void MotorFirmware::text_byte(uint8_t value, uint32_t now_ms) {
  if (value != '\n' && value != '\r') {
    if (line_size_ + 1 < kMaxLine) {
      line_[line_size_++] = static_cast<char>(value);
    } else {
      line_overflowed_ = true;
    }
    return;
  }
  line_[line_size_] = '\0';
  if (line_size_ != 0 && !line_overflowed_) obey_line(now_ms);
  line_size_ = 0;
  line_overflowed_ = false;
}

void MotorFirmware::obey_line(uint32_t now_ms) {
  const char* at = line_ + 1;
  float first = 0.0f, second = 0.0f;
  const bool has_first = read_number(at, first);
  const bool has_second = has_first && read_number(at, second);
  while (*at == ' ') ++at;
  if (*at != '\0') return;  // a damaged line moves nothing
  if (line_[0] == 'M' && has_second) {
    speaks_text_ = true;
    command(first, second, now_ms);
  } else if (line_[0] == 'W' && has_first && !has_second && first >= 1.0f && first <= 60000.0f) {
    speaks_text_ = true;
    watchdog_ms_ = static_cast<uint16_t>(first);
  }
}

void MotorFirmware::tick(uint32_t now_ms) {
  if (!has_ticked_) {
    has_ticked_ = true;
    commanded_ms_ = controlled_ms_ = reported_ms_ = now_ms;
  }
  if (!watchdog_stopped_ && now_ms - commanded_ms_ > watchdog_ms_) {
    watchdog_stopped_ = true;
    stop();
  }
  if (hooks_.faults(hooks_.board) != 0) stop();
  if (now_ms - controlled_ms_ >= kControlPeriodMs) control(now_ms);
  if (now_ms - reported_ms_ >= period_ms_) {
    reported_ms_ = now_ms;
    report();
  }
}

void MotorFirmware::control(uint32_t now_ms) {
  const float elapsed_s = 0.001f * static_cast<float>(now_ms - controlled_ms_);
  controlled_ms_ = now_ms;
  for (int wheel = 0; wheel < 2; ++wheel) {
    const int32_t counts = hooks_.counts(hooks_.board, wheel);
    const int32_t moved = static_cast<int32_t>(static_cast<uint32_t>(counts) - static_cast<uint32_t>(counts_[wheel]));
    counts_[wheel] = counts;
    rate_rps_[wheel] = static_cast<float>(moved) * kTurnRad / tuning_.counts_per_turn / elapsed_s;
    const float target = target_rps_[wheel];
    if (target == 0.0f) {
      integral_[wheel] = 0.0f;
      hooks_.set_duty(hooks_.board, wheel, 0.0f);
      continue;
    }
    const float error = target - rate_rps_[wheel];
    const float direct = tuning_.feed_forward * target + tuning_.proportional * error;
    const float sum = integral_[wheel] + tuning_.integral * error * elapsed_s;
    const float duty = direct + sum;
    // The integral stands still while the duty is at its limit: it must not wind up against a blocked wheel.
    if (duty <= 1.0f && duty >= -1.0f) integral_[wheel] = sum;
    hooks_.set_duty(hooks_.board, wheel, limited(duty, 1.0f));
  }
}

void MotorFirmware::report() {
  if (speaks_text_) {
    report_text();
  } else {
    report_frame();
  }
}

void MotorFirmware::report_frame() {
  uint8_t frame[25];
  frame[0] = kStart;
  frame[1] = 0x81;
  frame[2] = 20;
  for (int wheel = 0; wheel < 2; ++wheel) {
    store(&frame[3 + 4 * wheel], static_cast<uint32_t>(counts_[wheel]), 4);
    store_float(&frame[11 + 4 * wheel], rate_rps_[wheel]);
  }
  store(frame + 19, hooks_.battery_mv(hooks_.board), 2);
  store(frame + 21, hooks_.faults(hooks_.board), 2);
  store(frame + 23, crc16(frame + 1, 22), 2);
  hooks_.send(hooks_.board, frame, sizeof frame);
}

void MotorFirmware::report_text() {
  Text text;
  text.put('E');
  for (int wheel = 0; wheel < 2; ++wheel) {
    text.put(' ');
    text.number(counts_[wheel]);
  }
  for (int wheel = 0; wheel < 2; ++wheel) {
    text.put(' ');
    text.decimal(rate_rps_[wheel]);
  }
  text.put('\n');
  text.put('B');
  text.put(' ');
  text.decimal(0.001f * static_cast<float>(hooks_.battery_mv(hooks_.board)));
  text.put('\n');
  text.put('F');
  text.put(' ');
  text.number(hooks_.faults(hooks_.board));
  text.put('\n');
  hooks_.send(hooks_.board, reinterpret_cast<const uint8_t*>(text.bytes), text.size);
}

}  // namespace motor_firmware
