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

/// Runs ready callbacks in the order in which they became ready, on one thread (or a few, if its policy says so) that sleeps
/// when there is nothing to do. Ready events, not wait-sets. Why no wake-up is lost: docs/wake_up.md.
///
/// Fair: whoever has more to do queues up again behind the others, so between two runs of one callback each other one that is
/// ready has run once.
/// A callback that overstays on the shared executor loses its place: the queue goes to a spare thread, and the late thread
/// becomes the spare when it returns. A lifecycle transition leaves its place before it starts. The spare runs the other
/// nodes: with one thread, two callbacks of one node never overlap, whatever their groups.
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

  /// Puts a ready thing at the end of the queue, once. False if its node's groups are closed: it will not run.
  bool post(Executable& executable) noexcept;
  /// The same under mutex(). Returns the word of a thread that must be woken when it is released, or null.
  [[nodiscard]] const std::atomic<std::uint32_t>* post_locked(Executable& executable) noexcept {
    if (executable.queued_.load(std::memory_order_relaxed) || executable.home_.closed_) return nullptr;
    enqueue(executable);
    return sleeping_ == 0 || called_ != 0 ? nullptr : call_sleeper();
  }
  /// What guards everything here, and the queues of the executables' messages; it may outlive the executor.
  [[nodiscard]] const std::shared_ptr<FutexMutex>& mutex() const { return shared_mutex_; }
  /// Starts a timer, or starts it anew (Timer::reset): then, and for a timer that can run at once, the first tick is a full
  /// period away. Other timers of up to a second join the beat of their period: their first tick is one to two periods away.
  void add_timer(TimerBase& timer);
  void cancel_timer(TimerBase& timer);
  /// The lifecycle gate: a timer behind a closed one does not even wake the thread. It keeps its rhythm.
  void set_timer_open(TimerBase& timer, bool open);
  [[nodiscard]] bool is_armed(const TimerBase& timer) const;
  /// Ticks that did not run because an earlier one was late.
  [[nodiscard]] std::uint64_t skipped(const TimerBase& timer) const;
  /// After this the thing does not run any more; waits for a run that is going on, unless called from within it.
  void forget(Executable& executable);

  /// The node is made: what has become ready meanwhile may run.
  void open(NodeGroups& node);
  /// Nothing of the node starts any more, and what waits is discarded; waits until what runs has returned, at most until the
  /// deadline. Returns false when it still runs.
  [[nodiscard]] bool close(NodeGroups& node, MonotonicTime deadline);

  /// Why the callback that calls this must not wait for something to run in that group: it would wait for itself. Empty if it
  /// may, and for every thread that is not the executor's.
  [[nodiscard]] std::string why_not_wait_for(const CallbackGroup& group) const;
  /// The same for a transition of that node.
  [[nodiscard]] std::string why_not_wait_for(const NodeGroups& node) const;

  /// What the supervisor asks: takes the queue from a callback that overstays, and makes one that hangs a fault, once.
  /// Returns after how long it must ask again: when the next callback would overstay, or Duration::max() if none runs.
  Duration supervise(const Limits& limits);
  /// True if nothing runs and nothing waits.
  [[nodiscard]] bool is_idle() const;
  /// How often a callback that overstayed lost the queue.
  [[nodiscard]] std::uint64_t handovers() const { return handovers_.load(std::memory_order_relaxed); }
  /// Threads ever started: as many as serve, and as many spares as there were late callbacks at the same time.
  [[nodiscard]] std::size_t thread_count() const;
  /// Threads that run callbacks when none is late.
  [[nodiscard]] std::uint32_t serving() const { return policy_.own && policy_.threads > 1 ? policy_.threads : 1; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Writes its threads into `out` from place `used` on, and moves `used`.
  void report_threads(std::vector<ThreadReport>& out, std::size_t& used) const;
  void report_load(const NodeGroups& node, LoadReport& out) const;
  /// What the calling thread runs at this moment, as text that stays while it does; empty on a thread that is no executor's.
  /// Async-signal-safe.
  struct RunsHere {
    const char *node = "", *what = "", *name = "";
  };
  [[nodiscard]] static RunsHere runs_here() noexcept;
  /// Called by a thread that has slept and has something to run; wakes the supervisor. To be set before the first post.
  void set_activity_hook(std::function<void()> hook) { activity_hook_ = std::move(hook); }

 private:
  struct Worker;
  class Calls;
  void work(Worker& self);
  void rest(Worker& self);
  void start_worker();
  /// Gives its place to another thread, if there is one to be had.
  void hand_over(Worker& late);
  void start();
  void stop();
  void enqueue(Executable& executable) {
    executable.queued_.store(true, std::memory_order_relaxed);
    ready_.push_back(executable);
  }
  [[nodiscard]] static bool admits(const Executable& executable);
  static void hold_back(Executable& executable);
  Executable* pop();
  void fire_due_timers(MonotonicTime now);
  [[nodiscard]] MonotonicTime first_due(const TimerBase& timer, MonotonicTime now) const;
  [[nodiscard]] Block* begin(Worker& self, Executable& executable, MonotonicTime now);
  void run(Worker& self, Executable& executable, Block* message, MonotonicTime now);
  static void note_exception(const Worker& self, const char* text);
  void finish(Worker& self, MonotonicTime now);
  [[nodiscard]] bool prepare_special(Worker& self);
  static void start_sample(Worker& self, NodeGroups& node);
  void begin_transition(Worker& self, Executable& executable);
  void finish_unusual(Worker& self, NodeGroups& node);
  void call(Worker& worker);
  [[nodiscard]] Worker* next_to_call() { return sleeping_ == 0 || called_ != 0 ? nullptr : choose_sleeper(); }
  [[nodiscard]] Worker* choose_sleeper();
  [[nodiscard]] const std::atomic<std::uint32_t>* call_sleeper();
  void note_return();
  void wait_for_return();
  [[nodiscard]] std::string why_not_wait(const NodeGroups& node, const CallbackGroup* group) const;

  const std::string name_;
  const Clock& clock_;
  const ThreadPolicy policy_;
  const MonotonicTime epoch_ = clock_.now();  // of the beats that timers share
  std::function<void()> activity_hook_;

  const std::shared_ptr<FutexMutex> shared_mutex_ = std::make_shared<FutexMutex>();
  // Guards everything below, what NodeGroups, CallbackGroup, Executable and TimerBase keep for us, and the queues of messages.
  FutexMutex& mutex_ = *shared_mutex_;
  ReadyList ready_;
  TimerQueue timers_;
  bool stopping_ = false;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::uint32_t sleeping_ = 0;  // threads that have found nothing to do
  std::uint32_t called_ = 0;    // threads that were woken and have not looked yet
  Worker* keeper_ = nullptr;    // the sleeper that wakes for timers, and when
  MonotonicTime kept_until_ = kNever;
  std::uint32_t waiting_for_return_ = 0;
  std::atomic<std::uint32_t> return_word_{0};  // moves when a callback returns while somebody waits for that
  std::atomic<std::uint64_t> handovers_{0};
};

}  // namespace nacelle::runtime
