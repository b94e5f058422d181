// SPDX-License-Identifier: Apache-2.0
#include "range/component/range_loop.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "nacelle/io/backoff.hpp"
#include "range/model/sound.hpp"

namespace nacelle::range {

RangeLoop::RangeLoop(RangeOptions options, const Clock& clock, OpenLines open_lines, std::unique_ptr<EchoLines>& lines,
                     std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher, DeviceWatch& watch,
                     std::function<void(const std::string&)> on_exception)
    : options_(std::move(options)),
      clock_(clock),
      open_lines_(std::move(open_lines)),
      publisher_(std::move(publisher)),
      watch_(watch),
      on_exception_(std::move(on_exception)),
      lines_(lines),
      thread_([this] { run(); }) {}

RangeLoop::~RangeLoop() {
  {
    const LockGuard lock{mutex_};
    ended_ = true;
    if (lines_) lines_->interrupt();
  }
  end_asked_.notify_all();
  thread_.join();
}

bool RangeLoop::pause(Duration length) {
  UniqueLock lock{mutex_};
  return !end_asked_.wait_for(lock.raw(), length, [this]() NACELLE_REQUIRES(mutex_) { return ended_; });
}

void RangeLoop::run() {
  ::pthread_setname_np(::pthread_self(), "range");
  try {
    measure();
  } catch (const std::exception& e) { on_exception_(e.what()); }
}

void RangeLoop::measure() {
  const Duration period = from_seconds(1.0 / options_.rate_hz);
  io::Backoff backoff{50ms, 1s};
  std::optional<HcSr04> sensor;
  Duration left{};
  while (pause(left)) {
    if (!lines_) {
      if (!pause(backoff.next())) return;
      auto opened = open_lines_(options_.lines, clock_);
      if (!opened) {
        watch_.lose(opened.error().what);
        continue;
      }
      const LockGuard lock{mutex_};
      lines_ = std::move(opened).value();
      sensor.reset();
    }
    if (!sensor) sensor.emplace(*lines_, clock_);
    const MonotonicTime begin = clock_.now();
    const auto echo = sensor->measure();
    const MonotonicTime now = clock_.now();
    if (echo) {
      backoff.reset();
      publish(*echo, begin);
      watch_.heard(now);
    } else if (echo.error() == EchoFault::NoPulse) {
      {
        const LockGuard lock{mutex_};
        ++counters_.unanswered;
      }
      watch_.look(now, [] { return std::string("it does not answer its trigger"); });
    } else if (echo.error() == EchoFault::Lost) {
      watch_.lose("its GPIO chip is gone");
      const LockGuard lock{mutex_};
      sensor.reset();
      lines_.reset();
    }
    left = std::max(Duration::zero(), period - (clock_.now() - begin));
  }
}

void RangeLoop::publish(Duration echo, MonotonicTime at) {
  const double range_m = echo >= HcSr04::kNoObstacle
                             ? std::numeric_limits<double>::infinity()
                             : echo_range_m(echo, options_.temperature_c, options_.least_m, options_.most_m);
  {
    const LockGuard lock{mutex_};
    ++counters_.measured;
  }
  auto message = publisher_->borrow();
  if (!message) return;  // every pooled message is still being read; the publisher counted it
  // Both clocks are read here, so that a step of the wall clock cannot come between measuring and stamping.
  message->header.stamp = clock_.wall_now() - (clock_.now() - at);
  message->header.frame_id = options_.frame_id;
  message->radiation_type = sensor_msgs::msg::Range::ULTRASOUND;
  message->field_of_view = static_cast<float>(options_.field_of_view_rad);
  message->min_range = static_cast<float>(options_.least_m);
  message->max_range = static_cast<float>(options_.most_m);
  message->range = static_cast<float>(range_m);
  publisher_->publish(std::move(message));
  const LockGuard lock{mutex_};
  ++counters_.published;
}

RangeCounters RangeLoop::counters() const {
  const LockGuard lock{mutex_};
  return counters_;
}

}  // namespace nacelle::range
