// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "../model/simulated_motor.hpp"
#include "base_rig.hpp"
#include "diff_drive/port/counter_encoders.hpp"
#include "diff_drive/port/edge_encoders.hpp"
#include "diff_drive/port/pwm_base_port.hpp"
#include "nacelle/io/scripted_gpio.hpp"

namespace nacelle::diff_drive {

/// Files as the kernel's PWM and counter have them, in a folder of its own. They remember what is written, and check nothing.
class PwmTree {
 public:
  PwmTree() {
    std::string name = (std::filesystem::temp_directory_path() / "nacelle_pwm_XXXXXX").string();
    root_ = ::mkdtemp(name.data());
    std::filesystem::create_directories(chip());
    put("pwmchip0/npwm", "2\n");
    put("pwmchip0/export", "");
    put("pwmchip0/unexport", "");
    for (const unsigned channel : {0U, 1U}) add_channel(channel);
    for (const char* wheel : {"count0", "count1"}) {
      std::filesystem::create_directories(root_ + "/counter0/" + wheel);
      put(std::string("counter0/") + wheel + "/count", "0\n");
      put(std::string("counter0/") + wheel + "/function", "quadrature x4\n");
    }
  }
  ~PwmTree() { std::filesystem::remove_all(root_); }
  PwmTree(const PwmTree&) = delete;
  PwmTree& operator=(const PwmTree&) = delete;

  void add_channel(unsigned channel) {
    const std::string folder = "pwmchip0/pwm" + std::to_string(channel);
    std::filesystem::create_directories(root_ + "/" + folder);
    for (const char* file : {"period", "duty_cycle", "enable"}) put(folder + "/" + file, "0\n");
    put(folder + "/polarity", "normal\n");
  }
  [[nodiscard]] std::string chip() const { return root_ + "/pwmchip0"; }
  [[nodiscard]] std::string counter(unsigned wheel) const { return root_ + "/counter0/count" + std::to_string(wheel); }
  [[nodiscard]] const std::string& root() const { return root_; }

  /// Writes in place, as a driver that holds the file open expects it.
  void put(const std::string& file, const std::string& text) const {
    std::ofstream{root_ + "/" + file, std::ios::trunc} << text;
  }
  /// The first line: bytes behind it are of longer values before.
  [[nodiscard]] std::string get(const std::string& file) const {
    std::ifstream stream{root_ + "/" + file};
    std::string line;
    std::getline(stream, line);
    return line;
  }
  [[nodiscard]] std::string of_channel(unsigned channel, const std::string& file) const {
    return get("pwmchip0/pwm" + std::to_string(channel) + "/" + file);
  }
  /// What a channel puts out: a share of the time.
  [[nodiscard]] double share(unsigned channel) const {
    if (of_channel(channel, "enable") != "1") return 0.0;
    return std::stod(of_channel(channel, "duty_cycle")) / std::stod(of_channel(channel, "period"));
  }

 private:
  std::string root_;
};

/// Makes a channel of the tree refuse its values, as when the driver is unbound: its descriptor leads to a full device.
inline void break_channel(int descriptor) {
  const int full = ::open("/dev/full", O_WRONLY | O_CLOEXEC);
  ::dup2(full, descriptor);
  ::close(full);
}

/// Two motors behind H-bridges, and their encoders: they turn as the channels and lines command, and count or send edges as they turn. The test
/// sets the time.
class PwmPlant {
 public:
  enum class Encoder { Counter, Quadrature, OneChannel };

  PwmPlant(PwmTree& tree, ToldClock& clock, Encoder encoder, double counts_per_turn)
      : tree_(tree), clock_(clock), encoder_(encoder), counts_per_turn_(counts_per_turn) {}

  [[nodiscard]] std::unique_ptr<HBridges> motors() {
    auto lines = std::make_unique<io::ScriptedOutputs>();
    outputs = lines.get();
    const auto channel = [&](unsigned number) {
      return PwmChannel::open({.chip = tree_.chip(), .channel = number, .period_ns = 1'000'000'000}).value();
    };
    return std::make_unique<HBridges>(channel(0), channel(1), std::move(lines));
  }
  [[nodiscard]] std::unique_ptr<WheelEncoders> encoders() {
    if (encoder_ == Encoder::Counter) return CounterEncoders::open(tree_.counter(0), tree_.counter(1)).value();
    auto lines = std::make_unique<io::ScriptedInputs>();
    inputs = lines.get();
    return std::make_unique<EdgeEncoders>(std::move(lines), encoder_ == Encoder::Quadrature);
  }

  /// Turns the motors by what their channels and lines say until then, in steps of less than an edge, and sets the clock.
  void run_until(MonotonicTime until) {
    const std::array<double, 2> supplies{supply(0), supply(1)};
    while (clock_.now() < until) {
      const Duration step = std::min<Duration>(until - clock_.now(), encoder_ == Encoder::Counter ? 20ms : 200us);
      clock_.advance(step);
      for (unsigned wheel = 0; wheel < 2; ++wheel) {
        wheels.at(wheel).run(supplies.at(wheel), to_seconds(step));
        show(wheel);
      }
    }
  }
  /// What a motor gets: its channel's share, in the direction of its lines; nothing without a direction, or with both (a brake).
  [[nodiscard]] double supply(unsigned wheel) const {
    const std::uint64_t lines = outputs->levels >> (2 * wheel);
    const double sign = static_cast<double>(lines & 1U) - static_cast<double>((lines >> 1U) & 1U);
    return sign * tree_.share(wheel);
  }

  std::array<SimulatedMotor, 2> wheels;
  std::array<double, 2> encoder_sign{1.0, 1.0};
  io::ScriptedOutputs* outputs = nullptr;
  io::ScriptedInputs* inputs = nullptr;

 private:
  void show(unsigned wheel) {
    const double turns = encoder_sign.at(wheel) * wheels.at(wheel).angle_rad / (2.0 * M_PI);
    const auto count = static_cast<std::int64_t>(std::floor(turns * counts_per_turn_ + 1e-9));
    if (encoder_ == Encoder::Counter) {
      tree_.put("counter0/count" + std::to_string(wheel) + "/count",
                std::to_string(static_cast<std::uint64_t>(count)) + "\n");
      return;
    }
    const auto phase = static_cast<unsigned>(((count % 4) + 4) % 4);
    if (encoder_ == Encoder::OneChannel) {
      inputs->set(wheel, phase % 2 == 1, clock_.now());
      return;
    }
    inputs->set(2 * wheel, phase == 1 || phase == 2, clock_.now());
    inputs->set(2 * wheel + 1, phase == 2 || phase == 3, clock_.now());
  }

  PwmTree& tree_;
  ToldClock& clock_;
  const Encoder encoder_;
  const double counts_per_turn_;
};

/// A base of ideal motors, for the laws of BasePort: they reach a commanded speed at once.
class PwmRig final : public BaseRig {
 public:
  static constexpr double kCounts = 2e6, kFullSpeed = 20.0;

  PwmRig() {
    for (auto& wheel : plant_.wheels) wheel = {.full_speed_rps = kFullSpeed, .time_constant_s = 0.0005};
    PwmBasePort::Settings settings;
    settings.counts_per_turn = kCounts;
    settings.max_wheel_rate_rps = kFullSpeed;
    settings.pid = {.feed_forward = 1.0 / kFullSpeed};
    port_ = std::make_unique<PwmBasePort>(plant_.motors(), plant_.encoders(), clock_, settings,
                                          [this](MonotonicTime until) { plant_.run_until(until); });
  }
  BasePort& port() override { return *port_; }
  const Clock& clock() override { return clock_; }
  WheelState run(Duration length) override {
    const MonotonicTime end = clock_.now() + length;
    Heard heard;
    while (clock_.now() < end) static_cast<void>(port_->read_until(std::min(end, clock_.now() + 20ms), heard));
    states += heard.states.size();
    return heard.states.back();
  }
  void write_as_stranger(ByteView bytes) override {
    static_cast<void>(!::write(port_->descriptor(), bytes.data(), bytes.size()));
    for (const int further : port_->further_descriptors())
      static_cast<void>(!::write(further, bytes.data(), bytes.size()));
  }
  [[nodiscard]] bool can_tear() const override { return false; }

 private:
  ToldClock clock_;
  PwmTree tree_;
  PwmPlant plant_{tree_, clock_, PwmPlant::Encoder::Counter, kCounts};
  std::unique_ptr<PwmBasePort> port_;
};

}  // namespace nacelle::diff_drive
