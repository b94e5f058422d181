// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <utility>
#include <vector>

#include "nacelle/runtime/executor.hpp"

namespace nacelle::runtime {

/// Runs a function. Ends itself with its scope.
class Callable final : public Executable {
 public:
  Callable(CallbackGroup& group, std::function<void()> what, Kind kind = Kind::Callback)
      : Executable(group, kind), what_(std::move(what)) {}
  ~Callable() override { group().executor().forget(*this); }
  void execute(MonotonicTime) override { what_(); }
  void discard() noexcept override { discarded = true; }
  /// Wants to run again as long as this says so.
  std::function<bool()> again = [] { return false; };
  bool wants_again() const override { return again(); }
  std::atomic<bool> discarded{false};
  using Executable::keep_stats_in;

 private:
  std::function<void()> what_;
};

class Tick final : public TimerBase {
 public:
  Tick(CallbackGroup& g, Duration period, std::function<void()> what) : TimerBase(g, period), what_(std::move(what)) {}
  ~Tick() override {
    group().executor().cancel_timer(*this);
    group().executor().forget(*this);
  }
  void execute(MonotonicTime) override { what_(); }

 private:
  std::function<void()> what_;
};

/// Opens on request; a thread that waits too long (a test that would hang otherwise) gets false.
class Door {
 public:
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  [[nodiscard]] bool wait() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 20s, [&] { return open_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
};

/// Passable for two at once only.
class Meeting {
 public:
  [[nodiscard]] bool meet(Duration limit = 20s) {
    std::unique_lock lock(mutex_);
    ++here_;
    changed_.notify_all();
    const bool met = changed_.wait_for(lock, limit, [&] { return here_ >= 2; });
    if (!met) --here_;
    return met;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int here_ = 0;
};

/// Everything posted to the group before has run when this returns.
inline void drain(CallbackGroup& group) {
  Door done;
  Callable last(group, [&] { done.open(); });
  group.executor().post(last);
  EXPECT_TRUE(done.wait());
}

}  // namespace nacelle::runtime
