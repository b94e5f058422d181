// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/node/transport.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

class Executor;
class CallbackGroup;

/// Something that can be ready to run: a subscription with messages, a due timer, a call, a task. Belongs to one group.
///
/// Ownership: whoever made it; it must be detached from its executor (Executor::forget) before it is destroyed.
class Executable : public ReadyListener {
 public:
  explicit Executable(CallbackGroup& group) : group_(group) {}
  ~Executable() override = default;

  /// Runs once. `now` is the time of the start. Exceptions become a fault of the component.
  virtual void execute(MonotonicTime now) = 0;
  /// True if there is more to do at once.
  [[nodiscard]] virtual bool wants_again() const { return false; }
  /// True for callbacks that may take seconds by nature (lifecycle transitions): late is not hung.
  /// On a shared executor the others move to the spare thread before it starts, not when it is late.
  [[nodiscard]] virtual bool may_take_long() const { return false; }
  /// Its group was closed while it waited: it will never run. Called under the executor's lock; may delete itself.
  virtual void on_dropped() noexcept {}
  void on_ready() noexcept final;
  [[nodiscard]] CallbackGroup& group() const { return group_; }

 private:
  friend class Executor;
  CallbackGroup& group_;
  Executable* next_ = nullptr;  // in the ready queue or a group's backlog; under the executor's lock
  std::atomic<bool> queued_{false};
};

/// Fires at a fixed period; see Timer. Threads: under its executor's lock, or from its own callback.
class TimerBase : public Executable {
 public:
  TimerBase(CallbackGroup& group, Duration period) : Executable(group), period_(period) {}
  /// Whether a tick is wanted now; a gated node answers no, and the tick is skipped.
  [[nodiscard]] virtual bool is_open() const { return true; }

 private:
  friend class Executor;
  const Duration period_;
  MonotonicTime due_;
  bool armed_ = false;
};

/// Callbacks of one group never run at the same time (rclcpp's mutually exclusive group). One per node.
class CallbackGroup {
 public:
  using OnFault = std::function<void(std::string code, std::string text)>;
  CallbackGroup(Executor& executor, std::string name, OnFault on_fault)
      : executor_(executor), name_(std::move(name)), on_fault_(std::move(on_fault)) {}

  [[nodiscard]] Executor& executor() const { return executor_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  friend class Executor;
  Executor& executor_;
  const std::string name_;
  const OnFault on_fault_;
  bool busy_ = false;  // under the executor's lock, as the rest
  bool held_ = false;
  bool closed_ = false;
  Executable* backlog_ = nullptr;  // ready while the group was busy
};

/// Runs ready callbacks in the order in which they became ready, one at a time, on one thread that sleeps when there is nothing
/// to do. Ready events, not wait-sets.
///
/// A callback that overstays loses the executor: hand_over() gives queue and timers to a spare thread, and the late thread
/// becomes the spare when it returns. Its own group stays closed to others meanwhile.
/// Threads: all public members from any thread.
class Executor {
 public:
  struct Limits {
    Duration handover_after, hang_after;
  };
  Executor(std::string name, const Clock& clock, ThreadPolicy policy);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// Puts a ready thing at the end of the queue, once.
  void post(Executable& executable) noexcept;
  void add_timer(TimerBase& timer);
  void cancel_timer(TimerBase& timer);
  [[nodiscard]] bool is_armed(const TimerBase& timer) const;
  /// After this the thing does not run any more; waits for a run that is going on, unless called from within it.
  void forget(Executable& executable);
  /// What becomes ready in the group waits until open(): its node is still being made.
  void hold(CallbackGroup& group);
  void open(CallbackGroup& group);
  /// Nothing of the group starts any more, what waits is dropped; waits until what runs has returned, at most until the
  /// deadline. Returns false when it still runs.
  [[nodiscard]] bool close(CallbackGroup& group, MonotonicTime deadline);

  /// What the supervisor asks: takes the queue from a callback that overstays, and makes one that hangs a fault, once.
  void supervise(const Limits& limits);
  /// True if nothing runs and nothing waits.
  [[nodiscard]] bool is_idle() const;
  [[nodiscard]] std::uint64_t handovers() const { return handovers_.load(std::memory_order_relaxed); }
  /// Threads ever started: one, and as many spares as there were late callbacks at the same time.
  [[nodiscard]] std::size_t thread_count() const;
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Called when a sleeping executor gets work; wakes the supervisor.
  void set_activity_hook(std::function<void()> hook) { activity_hook_ = std::move(hook); }

 private:
  struct Worker;
  void work(Worker& self);
  void run_as_owner(Worker& self);
  void start_worker();
  void append(Executable& executable);
  Executable* pop();
  void fire_due_timers(MonotonicTime now);
  void finish(Worker& self, Executable* executable, CallbackGroup& group);
  void unlink(Executable*& list, Executable& executable);
  void hand_over();
  void drop_waiting(Executable*& list, const CallbackGroup& group);
  bool group_has_run(const CallbackGroup& group) const;

  const std::string name_;
  const Clock& clock_;
  const ThreadPolicy policy_;
  std::function<void()> activity_hook_;

  mutable FutexMutex mutex_;
  Executable* head_ = nullptr;
  Executable* tail_ = nullptr;
  std::vector<TimerBase*> timers_;
  MonotonicTime next_due_;
  bool sleeping_ = false;
  bool stopping_ = false;
  Worker* owner_ = nullptr;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::atomic<std::uint32_t> wake_word_{0};
  std::atomic<std::uint32_t> finished_word_{0};  // moves when a callback returns that somebody waits for
  std::atomic<std::uint32_t> waiters_{0};
  std::atomic<std::uint64_t> handovers_{0};
};

}  // namespace nacelle::runtime
