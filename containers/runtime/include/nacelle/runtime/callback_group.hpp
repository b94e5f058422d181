// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "nacelle/base/histogram.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/callback_group.hpp"
#include "nacelle/host/transport.hpp"

namespace nacelle::runtime {

class Executable;
class Executor;
class CallbackGroup;
class ReaderQueue;

/// The cost of one callback so far. Threads: written by its executor only, read from any thread.
struct CallbackStats {
  DurationHistogram duration;  ///< Start to return.
  DurationHistogram latency;   ///< Ready (a timer due, a call arrived) to start.
};

/// An intrusive list of executables in the order in which they wait. Threads: under the executor's lock.
class ReadyList {
 public:
  ReadyList() = default;
  ReadyList(const ReadyList&) = delete;
  ReadyList& operator=(const ReadyList&) = delete;
  [[nodiscard]] bool empty() const { return first_ == nullptr; }
  void push_back(Executable& executable);
  [[nodiscard]] Executable* pop_front();  // null when empty
  /// Moves all of another list to the front of this one.
  void prepend(ReadyList& other);
  void remove(const Executable& executable);
  [[nodiscard]] Executable* first() const { return first_; }

 private:
  Executable* first_ = nullptr;
  Executable** end_ = &first_;  // where the next one is linked
};

/// All callback groups of one node. A transition waits for them, and unloading closes them.
///
/// Holds all callbacks back until Executor::open(), so that no callback of a node runs during its constructor.
/// Ownership: the node. Outlives its groups and their executables.
class NodeGroups {
 public:
  /// Reports a fault of the node. `callback` is the place, for display ("subscription /scan", "timer 10 ms").
  using OnFault = std::function<void(std::string code, std::string text, std::string callback)>;
  NodeGroups(Executor& executor, std::string name, OnFault on_fault);
  ~NodeGroups();
  NodeGroups(const NodeGroups&) = delete;
  NodeGroups& operator=(const NodeGroups&) = delete;

  [[nodiscard]] Executor& executor() const { return executor_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  friend class Executor;
  friend class Executable;
  Executor& executor_;
  const std::string name_;
  const OnFault on_fault_;
  const bool one_at_a_time_;  // the executor has one thread: a spare that replaces a late thread runs the other nodes
  // All under the executor's lock.
  bool barred_ = true;  // callbacks may not start: not opened yet, or a transition runs or waits
  bool opened_ = false;
  bool closed_ = false;
  bool alone_ = false;                           // a transition runs
  std::uint32_t running_ = 0;                    // callbacks, of all groups together
  std::uint32_t pins_ = 0;                       // threads that are reporting a fault of this node
  const Executable* next_transition_ = nullptr;  // waits for running callbacks; no other callback starts before it
  ReadyList backlog_;  // ready, but not admitted; all of it was ready before anything in the executor's queue
  std::uint32_t until_sample_ = 1;
  std::uint32_t random_ = 2463534242;
  std::uint64_t planned_ = 1, samples_ = 0;  // callbacks up to the next sample
  Duration sampled_cpu_{};
};

/// One callback group of a node; the type says which callbacks may run in parallel.
class CallbackGroup final : public nacelle::CallbackGroup {
 public:
  explicit CallbackGroup(NodeGroups& node, CallbackGroupType type = CallbackGroupType::MutuallyExclusive)
      : nacelle::CallbackGroup(type), node_(node) {}
  [[nodiscard]] NodeGroups& node() const { return node_; }
  [[nodiscard]] Executor& executor() const { return node_.executor(); }

 private:
  friend class Executor;
  friend class Executable;
  NodeGroups& node_;
  const bool reentrant_ = type() == CallbackGroupType::Reentrant;
  std::uint32_t running_ = 0;  // under the executor's lock
};

/// A unit that the executor can run: a subscription with messages, a due timer, a call, a task. Belongs to one group.
///
/// Ownership: its creator, which must detach it from its executor (Executor::forget) before destroying it.
class Executable : public ReadyListener {
 public:
  enum class Kind : std::uint8_t {
    Callback,    ///< A component's callback; expected to return soon.
    Timer,       ///< The callback of a TimerBase.
    Transition,  ///< Runs while no callback of its node does, and may take seconds: late is not hung.
  };
  explicit Executable(CallbackGroup& group, Kind kind = Kind::Callback)
      : group_(group), home_(group.node()), kind_(kind), busy_(what_bars(group)) {}
  ~Executable() override = default;

  /// Runs the callback once. `now` is the time of the start. Exceptions become a fault of the component.
  virtual void execute(MonotonicTime now) = 0;
  /// Runs the callback with the message that the executor took for it; takes over its reference. Only for executables
  /// with a queue. If the queue is empty, or its next message needs further checks, the executor calls execute()
  /// instead, which takes from the queue itself.
  virtual void execute_with(Block& message, MonotonicTime now);
  /// Returns true if there is more to do at once. Not called for executables with a queue.
  [[nodiscard]] virtual bool wants_again() const { return false; }
  /// Returns the time after which a transition counts as hung and is reported. Called under the executor's lock.
  [[nodiscard]] virtual Duration time_limit() const noexcept { return Duration::max(); }
  /// Called if it will not run because its node's groups were closed while it waited. Under the executor's lock.
  virtual void discard() noexcept {}
  /// Queues the executable. Precondition: the caller holds the lock that guards the data that became ready, or has held
  /// it since they became ready (docs/wake_up.md, rule 2).
  void on_ready() noexcept final;
  [[nodiscard]] CallbackGroup& group() const { return group_; }
  /// Sets the names for display and for a crash record. A signal handler reads them, so they must be plain text that
  /// lives as long as this object.
  void describe_as(const char* what, const char* name) {
    label_ = what;
    label_name_ = name;
  }
  /// Returns "subscription /scan"; empty if describe_as() was not called.
  [[nodiscard]] std::string description() const;
  /// Sets the queue from which it takes its messages. Call before the first message arrives.
  void take_from(ReaderQueue& queue) { inbox_ = &queue; }

 protected:
  [[nodiscard]] ReaderQueue& inbox() const { return *inbox_; }
  /// Sets where the executor records each run; null: nowhere. Set before the first run.
  void keep_stats_in(CallbackStats& stats) { stats_ = &stats; }

 private:
  friend class Executor;
  friend class ReadyList;
  static const std::uint32_t* what_bars(const CallbackGroup& group) {
    static constexpr std::uint32_t kNothing = 0;
    if (group.node_.one_at_a_time_) return &group.node_.running_;
    return group.reentrant_ ? &kNothing : &group.running_;
  }
  CallbackGroup& group_;
  NodeGroups& home_;
  const Kind kind_;
  const std::uint32_t* const busy_;  // while not zero, it may not start; under the executor's lock
  Executable* next_ = nullptr;       // in the ready queue or a backlog; under the executor's lock
  std::atomic<bool> queued_{false};
  CallbackStats* stats_ = nullptr;
  ReaderQueue* inbox_ = nullptr;
  const char* label_ = "";       // "subscription"
  const char* label_name_ = "";  // "/scan"
};

inline void ReadyList::push_back(Executable& executable) {
  executable.next_ = nullptr;
  *end_ = &executable;
  end_ = &executable.next_;
}

inline Executable* ReadyList::pop_front() {
  Executable* const first = first_;
  if (first == nullptr) return nullptr;
  first_ = first->next_;
  if (first_ == nullptr) end_ = &first_;
  return first;
}

/// Fires at a fixed period; see Timer. Threads: under its executor's lock, or from its own callback.
class TimerBase : public Executable {
 public:
  TimerBase(CallbackGroup& group, Duration period) : Executable(group, Kind::Timer), period_(period) {}
  /// Returns when the next tick is due.
  [[nodiscard]] MonotonicTime due() const { return due_; }

 private:
  friend class Executor;
  friend class TimerQueue;
  static constexpr std::size_t kNotWaiting = ~std::size_t{0};

  const Duration period_;
  MonotonicTime due_;
  MonotonicTime was_due_;    // the tick that is in the ready queue
  std::uint64_t order_ = 0;  // timers that are due at the same time run in this order, in which they were queued
  std::size_t place_ = kNotWaiting;  // in the TimerQueue
  bool started_ = false;             // was added before: adding it again is a reset()
  bool armed_ = false;               // set by cancel() and reset()
  bool open_ = true;                 // set by the lifecycle gate; the timer runs if both are true
  std::uint64_t skipped_ = 0;
};

}  // namespace nacelle::runtime
