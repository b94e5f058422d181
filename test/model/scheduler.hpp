// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "nacelle/base/time.hpp"

namespace nacelle::model {

inline constexpr MonotonicTime kForEver{Duration::max()};

/// Lets one of its threads run at a time and chooses, by a seed, which one continues at every lock, unlock, wait and wake: a run is one
/// interleaving, and the same seed is the same run. Time stands still but for small steps when it is read; when every thread
/// waits, it jumps to the first deadline.
///
/// If every thread waits for ever, a wake-up was lost: it prints the seed and what each thread waits for, and ends the process.
/// Threads: the one that made it is its first thread; the others are model::Thread.
class Scheduler final : public Clock {
 public:
  explicit Scheduler(unsigned seed);
  ~Scheduler() override;
  [[nodiscard]] static Scheduler& current() { return *current_; }

  [[nodiscard]] MonotonicTime now() const override;
  [[nodiscard]] WallTime wall_now() const override { return {now_.since_origin}; }
  /// A number below n; part of the run that the seed stands for.
  [[nodiscard]] unsigned choose(unsigned n) { return n == 0 ? 0 : random_() % n; }

  /// A moment at which another thread may go on.
  void step();
  void sleep(Duration how_long);
  void wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, MonotonicTime deadline);
  void wake(const std::atomic<std::uint32_t>& word, int count);
  void lock(bool& taken);
  void unlock(bool& taken);

 private:
  friend class Thread;
  struct Participant {
    std::condition_variable turn;
    const void* waits_for = nullptr;  // a futex word, a mutex, a thread
    const char* kind = "";
    MonotonicTime until = kForEver;
    bool runnable = true;
    bool done = false;
  };
  std::size_t add();
  void begin(std::size_t id);
  void end(std::size_t id);
  void block(const void* on, const char* kind, MonotonicTime until);
  void release(const void* on, int count);
  void go_on(std::unique_lock<std::mutex>& lock);

  static inline Scheduler* current_ = nullptr;
  static thread_local std::size_t me_;
  const unsigned seed_;
  mutable std::mt19937 random_;
  unsigned stickiness_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Participant>> all_;
  std::size_t running_ = 0;
  mutable MonotonicTime now_{Duration{1'000'000'000}};
};

/// A thread of the current scheduler, in std::thread's words.
class Thread {
 public:
  Thread() = default;
  template <typename F>
  explicit Thread(F&& what)  // NOLINT(bugprone-forwarding-reference-overload): std::thread's own form
      : id_(Scheduler::current().add()) {
    thread_ = std::thread([id = id_, run = std::function<void()>(std::forward<F>(what))] {
      Scheduler::current().begin(id);
      run();
      Scheduler::current().end(id);
    });
  }
  void join();

 private:
  std::size_t id_ = 0;
  std::thread thread_;
};

}  // namespace nacelle::model
