// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/waveshare_command.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "nacelle/base/expect.hpp"

namespace nacelle::diff_drive {
namespace {

/// Writes into bytes that are known to suffice.
class LineWriter {
 public:
  explicit LineWriter(ByteSpan line)
      : begin_(reinterpret_cast<char*>(line.data())), at_(begin_), end_(begin_ + line.size()) {}

  void text(std::string_view part) {
    NACELLE_EXPECT(static_cast<std::size_t>(end_ - at_) >= part.size(), "a command line must fit its buffer");
    std::memcpy(at_, part.data(), part.size());
    at_ += part.size();
  }
  void integer(std::int64_t value) {
    const auto result = std::to_chars(at_, end_, value);
    NACELLE_EXPECT(result.ec == std::errc{}, "a command line must fit its buffer");
    at_ = result.ptr;
  }
  /// Four decimals without trailing zeros; never "-0".
  void decimal(double value) {
    const auto ten_thousandths = static_cast<std::int64_t>(std::llround(value * 1e4));
    const std::int64_t magnitude = ten_thousandths < 0 ? -ten_thousandths : ten_thousandths;
    if (ten_thousandths < 0) text("-");
    integer(magnitude / 10000);
    std::int64_t rest = magnitude % 10000;
    if (rest == 0) return;
    text(".");
    for (std::int64_t digit = 1000; rest != 0; digit /= 10) {
      integer(rest / digit);
      rest %= digit;
    }
  }
  [[nodiscard]] ByteView line() const {
    return {reinterpret_cast<const std::uint8_t*>(begin_), static_cast<std::size_t>(at_ - begin_)};
  }

 private:
  char* begin_;
  char* at_;
  char* end_;
};

}  // namespace

Result<ByteView, SpeedCommandFault> WaveshareCommandPrinter::wheel_speeds(double left_mps, double right_mps) {
  if (!std::isfinite(left_mps) || !std::isfinite(right_mps)) return err(SpeedCommandFault::NotFinite);
  if (std::abs(left_mps) > kWaveshareMaxWheelSpeed_mps || std::abs(right_mps) > kWaveshareMaxWheelSpeed_mps) {
    return err(SpeedCommandFault::TooFast);
  }
  LineWriter writer{line_};
  writer.text(R"({"T":1,"L":)");
  writer.decimal(left_mps);
  writer.text(R"(,"R":)");
  writer.decimal(right_mps);
  writer.text("}\n");
  return writer.line();
}

ByteView WaveshareCommandPrinter::number_command(unsigned type, std::int64_t value) {
  LineWriter writer{line_};
  writer.text(R"({"T":)");
  writer.integer(type);
  writer.text(R"(,"cmd":)");
  writer.integer(value);
  writer.text("}\n");
  return writer.line();
}

ByteView WaveshareCommandPrinter::motor_watchdog(std::chrono::milliseconds silence) {
  return number_command(136, silence.count());
}
ByteView WaveshareCommandPrinter::continuous_feedback(bool on) { return number_command(131, on ? 1 : 0); }
ByteView WaveshareCommandPrinter::feedback_delay(std::chrono::milliseconds delay) {
  return number_command(142, delay.count());
}
ByteView WaveshareCommandPrinter::echo(bool on) { return number_command(143, on ? 1 : 0); }

}  // namespace nacelle::diff_drive
