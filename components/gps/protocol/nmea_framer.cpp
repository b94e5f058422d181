// SPDX-License-Identifier: Apache-2.0
#include "gps/protocol/nmea_framer.hpp"

#include <charconv>
#include <utility>

namespace nacelle::gps {

void NmeaFramer::skip_pending() { stats_.skipped_bytes += std::exchange(length_, 0); }

void NmeaFramer::restart() {
  if (length_ > 0) ++stats_.broken;
  skip_pending();
}

bool NmeaFramer::take(std::uint8_t byte, MonotonicTime received) {
  ++stats_.bytes;
  const bool ends_line = byte == '\r' || byte == '\n';
  if (byte == '$') {
    restart();  // a sentence never holds a second `$`
    started_ = received;
    star_ = 0;
    sum_ = 0;
  } else if (length_ == 0 || ends_line) {
    restart();
    ++(ends_line ? stats_.line_end_bytes : stats_.skipped_bytes);
    return false;
  } else if (byte < 0x20 || byte > 0x7E || length_ == window_.size()) {
    restart();
    ++stats_.skipped_bytes;
    return false;
  }
  window_[length_++] = static_cast<char>(byte);
  if (star_ > 0) return length_ == star_ + 3 && close();
  if (byte == '*') {
    star_ = length_ - 1;
  } else if (byte != '$') {
    sum_ ^= byte;
  }
  return false;
}

bool NmeaFramer::close() {
  const char* const digits = window_.data() + star_ + 1;
  unsigned said = 0;
  const auto read = std::from_chars(digits, digits + 2, said, 16);
  if (read.ptr != digits + 2 || said != sum_) {
    ++stats_.bad_checksums;
    skip_pending();
    return false;
  }
  ++stats_.sentences;
  stats_.sentence_bytes += length_;
  return true;
}

}  // namespace nacelle::gps
