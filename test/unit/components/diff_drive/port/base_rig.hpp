// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <poll.h>
#include <unistd.h>

#include <charconv>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diff_drive/component/serial_base_port.hpp"
#include "diff_drive/component/waveshare_board.hpp"
#include "diff_drive/port/loopback_port.hpp"
#include "nacelle/io/pty_pair.hpp"
#include "nacelle/io/serial_port.hpp"

namespace nacelle::diff_drive {

/// A clock that the test sets.
class ToldClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime now() const override { return now_; }
  [[nodiscard]] WallTime wall_now() const override { return {1'700'000'000s + now_.since_origin}; }
  void set(MonotonicTime now) { now_ = now; }
  void advance(Duration by) { now_ += by; }

 private:
  MonotonicTime now_{100s};
};

/// Remembers every wheel state.
class Heard final : public WheelStateSink {
 public:
  void on_wheel_state(const WheelState& state) override { states.push_back(state); }
  std::vector<WheelState> states;
};

/// A base in front of which time passes when the test says so. One rig per implementation of BasePort.
class BaseRig {
 public:
  virtual ~BaseRig() = default;
  virtual BasePort& port() = 0;
  virtual const Clock& clock() = 0;
  /// Lets this much time of the wheels pass and a state of them from after it come through the port; returns it.
  virtual WheelState run(Duration length) = 0;
  /// As run(): how fast the wheels turn afterwards, as the port says.
  virtual WheelRates rates_after(Duration length) { return run(length).rates; }
  /// Writes bytes to the port's descriptor as a stranger would, and lets the base see them.
  virtual void write_as_stranger(ByteView bytes) = 0;
  /// Whether a command can get through in part: not where a write is a whole frame.
  [[nodiscard]] virtual bool can_tear() const { return true; }
  /// States that have come through the port in all runs.
  std::uint64_t states = 0;
};

class LoopbackRig final : public BaseRig {
 public:
  BasePort& port() override { return port_; }
  const Clock& clock() override { return clock_; }
  WheelState run(Duration length) override {
    const MonotonicTime end = clock_.now() + length;
    Heard heard;
    while (clock_.now() < end) static_cast<void>(port_.read_until(end, heard));
    states += heard.states.size();
    // The last whole period ends here: every length in the suite is a multiple of it.
    return heard.states.back();
  }
  void write_as_stranger(ByteView) override {}

 private:
  ToldClock clock_;
  LoopbackPort port_{clock_, {}, [this](MonotonicTime until) { clock_.set(until); }};
};

/// A minimal motor board on the device end of a real pty: it understands T 1 and sends T 1001.
class TinyBoard {
 public:
  explicit TinyBoard(io::PtyPair& pty) : pty_(pty) {}

  /// Takes lines until one of this type came. A stuck test ends after two seconds of silence.
  bool take_until(int type) {
    for (;;) {
      while (const auto line = next_line()) {
        lines.push_back(*line);
        if (obey(*line) == type) return true;
      }
      pollfd watched{pty_.device_end(), POLLIN, 0};
      if (::poll(&watched, 1, 2000) <= 0) return false;
      const auto bytes = pty_.read();
      if (!bytes) return false;
      buffer_ += as_text(bytes.value());
    }
  }
  /// Takes every line that has been written so far.
  void take_all() {
    for (pollfd watched{pty_.device_end(), POLLIN, 0}; ::poll(&watched, 1, 0) > 0;) {
      const auto bytes = pty_.read();
      if (!bytes) break;
      buffer_ += as_text(bytes.value());
    }
    while (const auto line = next_line()) {
      lines.push_back(*line);
      obey(*line);
    }
  }
  void say(double seconds) {
    left_m += left_mps * seconds;
    right_m += right_mps * seconds;
    send("{\"T\":1001,\"L\":" + std::to_string(left_mps) + ",\"R\":" + std::to_string(right_mps) +
         ",\"odl\":" + std::to_string(left_m) + ",\"odr\":" + std::to_string(right_m) + ",\"v\":12.0}\r\n");
  }
  void send(const std::string& text) { static_cast<void>(pty_.write_some(as_bytes(text))); }

  double left_mps = 0, right_mps = 0, left_m = 0, right_m = 0;
  std::vector<std::string> lines;

 private:
  std::optional<std::string> next_line() {
    const auto end = buffer_.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line = buffer_.substr(0, end);
    buffer_.erase(0, end + 1);
    return line;
  }
  static double number_after(const std::string& line, const std::string& key) {
    const auto at = line.find(key);
    double value = -1e9;
    if (at != std::string::npos) std::from_chars(line.data() + at + key.size(), line.data() + line.size(), value);
    return value;
  }
  int obey(const std::string& line) {
    const int type = static_cast<int>(number_after(line, "\"T\":"));
    if (type == 1) {
      left_mps = number_after(line, "\"L\":");
      right_mps = number_after(line, "\"R\":");
    }
    return type;
  }

  io::PtyPair& pty_;
  std::string buffer_;
};

class WaveshareRig final : public BaseRig {
 public:
  WaveshareRig() {
    auto line = io::SerialPort::open({pty_->path(), 115200, 100ms}, clock_);
    // The board says its lines at once, so the port's clock may be the kernel's: no test waits for it.
    port_ = std::make_unique<SerialBasePort>(std::move(line).value(),
                                             std::make_unique<WaveshareBoard>(WaveshareBoard::Settings{}), clock_,
                                             SerialBasePort::Settings{});
  }
  BasePort& port() override { return *port_; }
  const Clock& clock() override { return clock_; }
  WheelState run(Duration length) override {
    // Whatever the port wrote before this is on the line; a line of the test's own marks its end.
    write_as_stranger({});
    board.say(to_seconds(length));
    Heard heard;
    static_cast<void>(port_->read_until(clock_.now() + 2s, heard));
    states += heard.states.size();
    return heard.states.empty() ? WheelState{} : heard.states.back();
  }
  void write_as_stranger(ByteView bytes) override {
    static_cast<void>(!::write(port_->descriptor(), bytes.data(), bytes.size()));
    static_cast<void>(!::write(port_->descriptor(), "{\"T\":-3}\n", 9));
    board.take_until(-3);
  }
  void hang_up() { pty_->hang_up(); }

 private:
  SystemClock clock_;
  std::unique_ptr<io::PtyPair> pty_ = io::PtyPair::create().value();
  std::unique_ptr<SerialBasePort> port_;

 public:
  TinyBoard board{*pty_};
};

}  // namespace nacelle::diff_drive
