// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/policies/thread_policy.hpp"
#include "nacelle/runtime/callback_group.hpp"
#include "nacelle/runtime/futex.hpp"
#include "nacelle/runtime/reports.hpp"
#include "nacelle/runtime/timer_queue.hpp"

namespace nacelle::runtime {

/// Who runs an executor's callbacks: threads of its own, or the thread that calls run_ready().
enum class Running : std::uint8_t { ByThreads, ByCaller };

/// Runs ready callbacks in the order in which they became ready, on one thread (or several, by its policy) that sleeps
/// when there is nothing to do. It is driven by events, without wait sets. Why no wake-up is lost: docs/wake_up.md.
///
/// Fair: an executable with more to do queues again behind the others, so between two runs of one callback every other
/// ready callback runs once. If a callback on the shared executor runs too long, a spare thread takes over the queue,
/// and the late thread becomes a spare when it returns. A lifecycle transition hands the queue over before it starts.
/// The spare runs only other nodes: with one thread, two callbacks of one node never overlap, whatever their groups.
/// Threads: all public members from any thread.
class Executor {
 public:
  struct Limits {
    Duration handover_after, hang_after;
  };
  /// With Running::ByCaller it has no thread, and time passes as the clock says: run_ready() runs everything.
  Executor(std::string name, const Clock& clock, ThreadPolicy policy, Running running = Running::ByThreads);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// Puts a ready executable at the end of the queue, once. Returns false if its node's groups are closed: it will not
  /// run.
  bool post(Executable& executable) noexcept;
  /// The same under mutex(). Returns the word of a thread that must be woken when it is released, or null.
  [[nodiscard]] const std::atomic<std::uint32_t>* post_locked(Executable& executable) noexcept
      NACELLE_REQUIRES(mutex_) {
    if (executable.queued_.load(std::memory_order_relaxed) || executable.home_.closed_) return nullptr;
    enqueue(executable);
    return sleeping_ == 0 || called_ != 0 ? nullptr : call_sleeper();
  }
  /// Returns the mutex that guards the executor and the message queues of its executables; it may outlive the executor.
  [[nodiscard]] const std::shared_ptr<FutexMutex>& mutex() const { return shared_mutex_; }
  /// For the compiler's analysis: the caller holds mutex(), under the name that a queue has for it.
  void assume_locked() const NACELLE_ASSERTS_HELD(mutex_) {}
  /// Starts a timer, or restarts it (Timer::reset). After a restart, and for a timer that can run at once, the first
  /// tick is a full period away. Other timers with a period of up to a second tick at common multiples of the period:
  /// their first tick is one to two periods away.
  void add_timer(TimerBase& timer);
  void cancel_timer(TimerBase& timer);
  /// Opens or closes the lifecycle gate of a timer. Behind a closed gate the timer does not wake the thread, and keeps
  /// its phase.
  void set_timer_open(TimerBase& timer, bool open);
  [[nodiscard]] bool is_armed(const TimerBase& timer) const;
  /// Returns the number of ticks that were skipped because an earlier one was late.
  [[nodiscard]] std::uint64_t skipped(const TimerBase& timer) const;
  /// Removes an executable, which does not run any more afterwards. Waits for a running call, unless called from within
  /// it.
  void forget(Executable& executable);

  /// Opens a node that is constructed: executables that have become ready meanwhile may run.
  void open(NodeGroups& node);
  /// Closes a node: none of its callbacks starts any more, and waiting ones are discarded. Waits until running ones
  /// have returned, at most until the deadline. Returns false if one still runs.
  [[nodiscard]] bool close(NodeGroups& node, MonotonicTime deadline);

  /// Returns why the calling callback must not wait for a callback of that group (it would wait for itself). Empty if
  /// it may, and on threads of other executors.
  [[nodiscard]] std::string why_not_wait_for(const CallbackGroup& group) const;
  /// The same for a transition of that node.
  [[nodiscard]] std::string why_not_wait_for(const NodeGroups& node) const;

  /// Runs what is ready, and the timers that are due, on the calling thread, until nothing is. Does nothing within a callback of this
  /// executor, and with Running::ByThreads. Threads: one.
  void run_ready();
  [[nodiscard]] bool is_run_by_caller() const { return running_ == Running::ByCaller; }
  /// Returns when the next timer is due; kNever if none waits.
  [[nodiscard]] MonotonicTime next_timer() const;

  /// Called by the supervisor. Takes the queue from a callback that runs too long, and reports one that hangs as a
  /// fault, once. Returns the time until the next call: when the next callback would be late, or Duration::max() if
  /// none runs.
  Duration supervise(const Limits& limits);
  /// Returns true if something has been waiting to run since the last call, and nothing was started meanwhile. A callback that
  /// hangs does not count: supervise() deals with it. Call it at intervals much longer than handover_after.
  [[nodiscard]] bool has_stalled();
  /// Returns true if nothing runs and nothing waits.
  [[nodiscard]] bool is_idle() const;
  /// Returns how often a late callback lost the queue.
  [[nodiscard]] std::uint64_t handovers() const { return handovers_.load(std::memory_order_relaxed); }
  /// Returns the number of threads ever started: the serving ones, plus as many spares as callbacks were late at the
  /// same time.
  [[nodiscard]] std::size_t thread_count() const;
  /// Returns the number of threads that run callbacks while none is late.
  [[nodiscard]] std::uint32_t serving() const { return policy_.own && policy_.threads > 1 ? policy_.threads : 1; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Writes its threads into `out` from index `used` on, and advances `used`.
  void report_threads(std::vector<ThreadReport>& out, std::size_t& used) const;
  void report_load(const NodeGroups& node, LoadReport& out) const;
  /// Returns what the calling thread runs, as text that stays valid meanwhile; empty on a thread that belongs to no
  /// executor. Async-signal-safe.
  struct RunsHere {
    const char *node = "", *what = "", *name = "";
  };
  [[nodiscard]] static RunsHere runs_here() noexcept;
  /// Sets a hook that wakes the supervisor. A thread calls it when it has slept and has something to run. Set it before
  /// the first post.
  void set_activity_hook(std::function<void()> hook) { activity_hook_ = std::move(hook); }

 private:
  struct Worker;
  class Calls;
  void work(Worker& self);
  void rest(Worker& self) NACELLE_RELEASE(mutex_);
  void start_worker() NACELLE_REQUIRES(mutex_);
  /// Hands the queue to another thread, if one is available.
  void hand_over(Worker& late) NACELLE_REQUIRES(mutex_);
  void start();
  void stop() NACELLE_NOT_CHECKED;  // it joins without the lock: once stopping_ is set no thread is added
  void enqueue(Executable& executable) NACELLE_REQUIRES(mutex_) {
    executable.queued_.store(true, std::memory_order_relaxed);
    ready_.push_back(executable);
  }
  [[nodiscard]] static bool admits(const Executable& executable);
  static void hold_back(Executable& executable);
  Executable* pop() NACELLE_REQUIRES(mutex_);
  void fire_due_timers(MonotonicTime now) NACELLE_REQUIRES(mutex_);
  [[nodiscard]] MonotonicTime first_due(const TimerBase& timer, MonotonicTime now) const;
  [[nodiscard]] Block* begin(Worker& self, Executable& executable, MonotonicTime now) NACELLE_REQUIRES(mutex_);
  void run(Worker& self, Executable& executable, Block* message, MonotonicTime now);
  static void note_exception(const Worker& self, const char* text);
  void finish(Worker& self, MonotonicTime now) NACELLE_REQUIRES(mutex_);
  [[nodiscard]] bool prepare_special(Worker& self);
  static void start_sample(Worker& self, NodeGroups& node);
  void begin_transition(Worker& self, Executable& executable) NACELLE_REQUIRES(mutex_);
  void finish_unusual(Worker& self, NodeGroups& node) NACELLE_REQUIRES(mutex_);
  void call(Worker& worker) NACELLE_REQUIRES(mutex_);
  [[nodiscard]] Worker* next_to_call() NACELLE_REQUIRES(mutex_) {
    return sleeping_ == 0 || called_ != 0 ? nullptr : choose_sleeper();
  }
  [[nodiscard]] Worker* choose_sleeper() NACELLE_REQUIRES(mutex_);
  [[nodiscard]] const std::atomic<std::uint32_t>* call_sleeper() NACELLE_REQUIRES(mutex_);
  void note_return() NACELLE_REQUIRES(mutex_);
  [[nodiscard]] std::string why_not_wait(const NodeGroups& node, const CallbackGroup* group) const;

  const std::string name_;
  const Clock& clock_;
  const ThreadPolicy policy_;
  const Running running_;
  const bool hands_over_ = !policy_.own && running_ == Running::ByThreads;  // late callbacks lose the queue
  const MonotonicTime epoch_ = clock_.now();                                // origin of the ticks that timers share
  std::function<void()> activity_hook_;

  const std::shared_ptr<FutexMutex> shared_mutex_ = std::make_shared<FutexMutex>();
  // Guards everything below, the executor's data in NodeGroups, CallbackGroup, Executable and TimerBase, and the
  // message queues.
  FutexMutex& mutex_ = *shared_mutex_;
  ReadyList ready_ NACELLE_GUARDED_BY(mutex_);
  TimerQueue timers_ NACELLE_GUARDED_BY(mutex_);
  bool stopping_ NACELLE_GUARDED_BY(mutex_) = false;
  std::vector<std::unique_ptr<Worker>> workers_ NACELLE_GUARDED_BY(mutex_);
  std::uint32_t sleeping_ NACELLE_GUARDED_BY(mutex_) = 0;  // threads that have found nothing to do
  std::uint32_t called_ NACELLE_GUARDED_BY(mutex_) = 0;    // threads that were woken and have not looked yet
  Worker* keeper_ NACELLE_GUARDED_BY(mutex_) = nullptr;    // the sleeper that wakes for timers, and when
  MonotonicTime kept_until_ NACELLE_GUARDED_BY(mutex_) = kNever;
  std::uint32_t waiting_for_return_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool was_waiting_ NACELLE_GUARDED_BY(mutex_) = false;  // at the last call of has_stalled(), as the next
  MonotonicTime last_start_seen_ NACELLE_GUARDED_BY(mutex_){};
  std::atomic<std::uint32_t> return_word_{0};  // changes when a callback returns while a thread waits for that
  std::atomic<std::uint64_t> handovers_{0};
};

}  // namespace nacelle::runtime
