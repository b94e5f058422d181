// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/drive_loop.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "devices/device_runs.hpp"
#include "diff_drive/port/loopback_port.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {
namespace {

using namespace diff_drive;

constexpr Duration kPeriod = 1ms;
constexpr std::uint64_t kBlock = 1000, kWarmUp = 100;  // cycles

/// How late cycles end.
class Lateness final : public DriveObserver {
 public:
  /// Its memory is there before the first cycle.
  explicit Lateness(std::uint64_t cycles) : late_(cycles) { late_.clear(); }
  void begin(MonotonicTime at) { due_ = at; }
  void on_wheel_state(const WheelState&) override {}
  void on_cycle(const BodyTwist&, MonotonicTime now) override { note(now); }
  void on_command_written(Duration) override {}

  void note(MonotonicTime now) {
    due_ += kPeriod;
    late_.push_back(now - due_);
    if (now - due_ >= kPeriod) due_ = now;  // a cycle was skipped: the next is counted from here, as the loop does
  }
  /// Nanoseconds that one of `parts` is later than.
  [[nodiscard]] double quantile(std::size_t parts) {
    const auto at = late_.begin() + static_cast<std::ptrdiff_t>(late_.size() - 1 - late_.size() / parts);
    std::nth_element(late_.begin(), at, late_.end());
    return static_cast<double>(at->count());
  }

 private:
  MonotonicTime due_{};
  std::vector<Duration> late_;
};

void run_loop(DriveLoop& loop, const Clock& clock, Lateness& lateness, CommandInbox& inbox, std::uint64_t cycles) {
  const MonotonicTime begin = clock.now();
  inbox.sources[0].commands.put({{0.2, 0.1}, begin, begin});
  lateness.begin(begin);
  loop.arm(begin);
  for (std::uint64_t i = 0; i < cycles; ++i) {
    if (loop.cycle()) continue;
    std::fprintf(stderr, "the control loop ended with a fault\n");
    std::exit(1);
  }
}

/// What cyclictest does.
void sleep_only(const Clock& clock, Lateness& lateness, std::uint64_t cycles) {
  MonotonicTime due = clock.now();
  lateness.begin(due);
  for (std::uint64_t i = 0; i < cycles; ++i) {
    due += kPeriod;
    const auto since = due.nanoseconds();
    const timespec until{since / 1'000'000'000, since % 1'000'000'000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) != 0) {}
    lateness.note(clock.now());
  }
}

}  // namespace

void run_drive_loop(std::uint64_t cycles, bool compares) {
  const SystemClock clock;
  LoopbackPort port{clock, {.state_period = 1h}};  // without its own states: the loop's waits alone
  CommandInbox inbox;
  Lateness driven{cycles + kWarmUp}, bare{cycles};
  DriveLoop::Settings settings;
  settings.period = kPeriod;
  settings.silence_limit = {};
  DriveLoop loop{settings, port, clock, inbox, driven};
  run_loop(loop, clock, driven, inbox, kWarmUp);
  const Usage before = Usage::now();
  if (compares) {
    for (std::uint64_t done = 0; done < cycles; done += kBlock) {
      run_loop(loop, clock, driven, inbox, kBlock);
      sleep_only(clock, bare, kBlock);
    }
  } else {
    run_loop(loop, clock, driven, inbox, cycles);
  }
  const Usage used = Usage::now() - before;
  std::vector<std::pair<std::string, double>> figures{{"cycles", static_cast<double>(loop.stats().cycles)},
                                                      {"skipped", static_cast<double>(loop.stats().skipped)},
                                                      {"mallocs", static_cast<double>(used.mallocs)},
                                                      {"faults", static_cast<double>(used.faults)}};
  if (compares) {
    figures.emplace_back("p999_us", driven.quantile(1000) / 1000);
    figures.emplace_back("bare_p999_us", bare.quantile(1000) / 1000);
  }
  print_figures(figures);
}

}  // namespace nacelle::bench
