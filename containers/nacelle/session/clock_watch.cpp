// SPDX-License-Identifier: Apache-2.0
#include "session/clock_watch.hpp"

#include <fcntl.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string_view>

namespace nacelle::session {
namespace {

// NTP slews by at most 500 ppm: in this time by less than ClockWatch::kLeastStep.
constexpr time_t kPeriod_s = 60;

class KernelClockAlarm final : public ClockAlarm {
 public:
  KernelClockAlarm() : timer_(::timerfd_create(CLOCK_REALTIME, TFD_NONBLOCK | TFD_CLOEXEC)) { arm(); }
  ~KernelClockAlarm() override {
    if (timer_ >= 0) ::close(timer_);
  }
  int descriptor() const override { return timer_; }
  void take() override {
    // Either it expired, or the read fails with ECANCELED: the clock was set. ClockWatch determines which.
    std::uint64_t expirations = 0;
    static_cast<void>(!::read(timer_, &expirations, sizeof expirations));
    arm();
  }

 private:
  void arm() const {
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    itimerspec then{};
    then.it_value.tv_sec = now.tv_sec + kPeriod_s;
    ::timerfd_settime(timer_, TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, &then, nullptr);
  }
  int timer_;
};

}  // namespace

std::unique_ptr<ClockAlarm> make_kernel_clock_alarm() { return std::make_unique<KernelClockAlarm>(); }

std::optional<Duration> ClockWatch::look() {
  alarm_.take();
  const Duration now_is = offset();
  const Duration step = now_is - offset_;
  offset_ = now_is;
  return std::chrono::abs(step) < kLeastStep ? std::nullopt : std::optional{step};
}

Result<std::unique_ptr<TestClock>, Problem> TestClock::open(const std::string& fifo) {
  // Both ways, so that a writer which leaves is no end of file.
  const int descriptor = ::open(fifo.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0)
    return err(Problem{fifo, std::string{"cannot be opened ("} + std::strerror(errno) + ")", "make it with mkfifo"});
  return std::unique_ptr<TestClock>{new TestClock{descriptor}};
}

TestClock::~TestClock() { ::close(fifo_); }

void TestClock::take() {
  std::array<char, 64> bytes{};
  ssize_t count = 0;
  while ((count = ::read(fifo_, bytes.data(), bytes.size())) > 0) {
    for (const char c : std::string_view{bytes.data(), static_cast<std::size_t>(count)}) {
      if (c != '\n') {
        if (line_.size() < bytes.size()) line_.push_back(c);
        continue;
      }
      double step_s = 0.0;
      const auto read = std::from_chars(line_.data(), line_.data() + line_.size(), step_s);
      if (read.ec == std::errc{} && std::abs(step_s) < 1e8)
        offset_ns_.fetch_add(from_seconds(step_s).count(), std::memory_order_relaxed);
      line_.clear();
    }
  }
}

}  // namespace nacelle::session
