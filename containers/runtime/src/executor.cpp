// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/executor.hpp"

#include <algorithm>
#include <exception>
#include <limits>
#include <system_error>
#include <utility>

#include "executor_thread.hpp"
#include "executor_worker.hpp"
#include "nacelle/base/mutex.hpp"
#include "reader_queue.hpp"
#include "this_thread.hpp"

namespace nacelle::runtime {

thread_local Executor::Worker* Executor::Worker::here = nullptr;

void Executable::on_ready() noexcept {
  // For most messages of a busy stream, the executable is queued already.
  if (queued_.load(std::memory_order_relaxed)) return;
  home_.executor().post(*this);
}

Executor::Executor(std::string name, const Clock& clock, ThreadPolicy policy, Running running)
    : name_(std::move(name)), clock_(clock), policy_(std::move(policy)), running_(running) {
  try {
    start();
  } catch (...) {
    stop();
    throw;
  }
}

Executor::~Executor() { stop(); }

void Executor::start() {
  const LockGuard lock(mutex_);
  if (running_ == Running::ByCaller) {
    workers_.push_back(std::make_unique<Worker>(*this, true));  // stands for the calling thread
    workers_.back()->state = Worker::State::Awake;
    return;
  }
  for (std::uint32_t i = 0; i < serving(); ++i) {
    start_worker();
    ++called_;
  }
  // The spare exists from the start, because the moment in which a callback runs too long is a bad one to make a
  // thread. Executors of a single component need none: they serve no other component.
  if (policy_.own) return;
  start_worker();
  workers_.back()->state = Worker::State::Spare;
}

void Executor::stop() {
  {
    const LockGuard lock(mutex_);
    stopping_ = true;
    for (const auto& worker : workers_) {
      worker->state = Worker::State::Spare;  // takes no more work
      worker->word.store(worker->word.load() + 1);
    }
  }
  for (const auto& worker : workers_) futex_wake(worker->word, 1);
  if (running_ == Running::ByThreads) {
    for (const auto& worker : workers_) worker->thread.join();
  }
  while (Executable* const left = ready_.pop_front()) left->discard();
}

// Under the lock, as everything below until post().
void Executor::start_worker() {
  workers_.push_back(std::make_unique<Worker>(*this, workers_.empty()));
  Worker& worker = *workers_.back();
  try {
    worker.thread = Thread([this, &worker] { work(worker); });
  } catch (...) {
    workers_.pop_back();
    throw;
  }
}

// Returns the first ready executable that may run; moves those that may not to their node's backlog.
[[gnu::always_inline]] inline Executable* Executor::pop() {
  while (Executable* const first = ready_.pop_front()) {
    if (admits(*first)) return first;
    hold_back(*first);
  }
  return nullptr;
}

inline bool Executor::admits(const Executable& executable) {
  const NodeGroups& node = executable.home_;
  if (executable.kind_ != Executable::Kind::Transition) [[likely]]
    return !node.barred_ && *executable.busy_ == 0;
  return node.opened_ && node.running_ == 0;
}

void Executor::hold_back(Executable& executable) {
  NodeGroups& node = executable.home_;
  if (executable.kind_ == Executable::Kind::Transition && node.next_transition_ == nullptr) {
    node.next_transition_ = &executable;
    node.barred_ = true;
  }
  node.backlog_.push_back(executable);
}

void Executor::fire_due_timers(MonotonicTime now) {
  while (timers_.next_due() <= now) {
    TimerBase& timer = timers_.first();
    // A late tick is skipped: the next one is the next multiple of the period.
    const auto missed = (now - timer.due_) / timer.period_;
    const bool waits = timer.queued_.load(std::memory_order_relaxed);
    timer.skipped_ += static_cast<std::uint64_t>(missed) + (waits ? 1 : 0);
    if (!waits) timer.was_due_ = timer.due_;
    timers_.put(timer, timer.due_ + timer.period_ * (missed + 1));
    if (!waits && !timer.home_.closed_) enqueue(timer);
  }
}

// Chooses, before the lock is released, the thread to wake; the caller wakes it afterwards. The invariant of
// docs/wake_up.md: while something is ready or a timer is unwatched, no thread sleeps unless a called one is on its
// way.
Executor::Worker* Executor::choose_sleeper() {
  const bool timer = timers_.next_due() < kept_until_;
  if (ready_.empty() && !timer) return nullptr;
  Worker* chosen = nullptr;
  for (const auto& worker : workers_) {
    if (worker->state != Worker::State::Sleeping) continue;
    chosen = worker.get();
    // The thread that watches the timers is woken only if no other sleeps, or for an earlier timer.
    if ((chosen == keeper_) == (timer && keeper_ != nullptr)) break;
  }
  if (chosen == nullptr) return nullptr;  // no thread sleeps
  call(*chosen);
  return chosen;
}

const std::atomic<std::uint32_t>* Executor::call_sleeper() {
  Worker* const called = choose_sleeper();
  return called == nullptr ? nullptr : &called->word;
}

void Executor::call(Worker& worker) {
  if (worker.state == Worker::State::Sleeping) --sleeping_;
  worker.state = Worker::State::Called;
  ++called_;
  worker.word.store(worker.word.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

bool Executor::post(Executable& executable) noexcept {
  const std::atomic<std::uint32_t>* called = nullptr;
  {
    const LockGuard lock(mutex_);
    if (executable.home_.closed_) return false;
    called = post_locked(executable);
  }
  if (called != nullptr) futex_wake(*called, 1);
  return true;
}

void Executor::work(Worker& self) {
  prepare_this_thread(name_, policy_, self.first);
  const SignalStack signal_stack;
  Worker::here = &self;
  this_thread_runs_callbacks = true;
  MonotonicTime now = clock_.now();
  mutex_.lock();
  self.thread_id = this_thread_id();
  self.cpu_clock = cpu_clock_of_this_thread();
  if (self.state == Worker::State::Called) {
    --called_;
    self.state = Worker::State::Awake;
  }
  self.special |= Worker::kHasRested;
  for (;;) {
    Executable* next = nullptr;
    if (self.state != Worker::State::Spare) {
      if (now >= timers_.next_due()) fire_due_timers(now);
      next = pop();
    }
    if (next == nullptr) {
      if (stopping_) break;
      rest(self);
      now = clock_.now();
      mutex_.lock();
      self.special |= Worker::kHasRested;
      if (self.state == Worker::State::Called) --called_;
      if (self.state == Worker::State::Sleeping) --sleeping_;
      if (self.state != Worker::State::Spare) self.state = Worker::State::Awake;
      if (keeper_ == &self) {
        keeper_ = nullptr;
        kept_until_ = kNever;
      }
      continue;
    }
    Block* const message = begin(self, *next, now);
    Worker* const to_wake = next_to_call();
    mutex_.unlock();
    if (to_wake != nullptr) futex_wake(to_wake->word, 1);
    run(self, *next, message, now);
    // The end of one callback is the start of the next: one clock read serves both.
    now = clock_.now();
    mutex_.lock();
    finish(self, now);
  }
  mutex_.unlock();
}

void Executor::run_ready() {
  if (running_ == Running::ByThreads) return;
  this_thread_runs_callbacks = true;
  MonotonicTime now = clock_.now();
  mutex_.lock();
  Worker& self = *workers_.front();
  if (self.group != nullptr || stopping_) {
    mutex_.unlock();
    return;
  }
  if (self.thread_id == 0) {
    self.thread_id = this_thread_id();
    self.cpu_clock = cpu_clock_of_this_thread();
  }
  Worker* const outer = std::exchange(Worker::here, &self);
  for (;;) {
    if (now >= timers_.next_due()) fire_due_timers(now);
    Executable* const next = pop();
    if (next == nullptr) break;
    Block* const message = begin(self, *next, now);
    mutex_.unlock();
    run(self, *next, message, now);
    now = clock_.now();
    mutex_.lock();
    finish(self, now);
  }
  self.running = nullptr;
  self.group = nullptr;
  Worker::here = outer;
  mutex_.unlock();
}

// Releases the lock, and sleeps until called, or until the next timer is due if no other thread watches it.
void Executor::rest(Worker& self) {
  self.running = nullptr;
  self.group = nullptr;
  MonotonicTime until = kNever;
  if (self.state != Worker::State::Spare) {
    self.state = Worker::State::Sleeping;
    ++sleeping_;
    if (timers_.next_due() < kept_until_) {
      keeper_ = &self;
      until = kept_until_ = timers_.next_due();
    }
  }
  const std::uint32_t word = self.word.load(std::memory_order_relaxed);
  Worker* const to_wake = next_to_call();
  mutex_.unlock();
  if (to_wake != nullptr) futex_wake(to_wake->word, 1);
  // A caller from here on changes the word, so the wait returns at once.
  if (until == kNever) {
    futex_wait(self.word, word);
  } else {
    futex_wait_until(self.word, word, until);
  }
}

[[gnu::always_inline]] inline Block* Executor::begin(Worker& self, Executable& executable, MonotonicTime now) {
  CallbackGroup& group = executable.group_;
  NodeGroups& node = executable.home_;
  executable.queued_.store(false, std::memory_order_relaxed);
  ++group.running_;
  ++node.running_;
  self.running = &executable;
  self.group = &group;
  self.started = now;
  ReaderQueue* const inbox = executable.inbox_;
  if (executable.kind_ != Executable::Kind::Callback) [[unlikely]] {
    if (executable.kind_ == Executable::Kind::Transition) {
      begin_transition(self, executable);
      return nullptr;
    }
    // Recorded here and not by the callback: the next tick may become ready, and change the due time, before the
    // callback begins.
    if (executable.stats_ != nullptr)
      executable.stats_->latency.record(now - static_cast<const TimerBase&>(executable).was_due_);
  }
  if (--node.until_sample_ == 0) [[unlikely]]
    start_sample(self, node);
  if (inbox == nullptr) return nullptr;
  inbox->assume_locked();
  Block* const message = inbox->take_quickly();
  // In a reentrant group the next message need not wait for this one's callback.
  if (group.reentrant_ && message != nullptr && inbox->has_waiting()) enqueue(executable);
  return message;
}

void Executor::start_sample(Worker& self, NodeGroups& node) {
  self.unusual |= Worker::kSampled;
  self.special |= Worker::kMeasured;
  // Every 128th on average, at random: otherwise callbacks that alternate would be measured unfairly. Source:
  // Marsaglia's xorshift.
  node.random_ ^= node.random_ << 13;
  node.random_ ^= node.random_ >> 17;
  node.random_ ^= node.random_ << 5;
  node.until_sample_ = 65 + (node.random_ >> 8) % 127;
  node.planned_ += node.until_sample_;
}

void Executor::begin_transition(Worker& self, Executable& executable) {
  NodeGroups& node = executable.home_;
  self.unusual |= Worker::kAlone;
  node.alone_ = node.barred_ = true;
  if (node.next_transition_ == &executable) node.next_transition_ = nullptr;
  // A transition may take seconds: the other nodes do not wait for it, not even for handover_after.
  if (hands_over_) hand_over(self);
}

// Without the lock. Returns whether the run's CPU time is measured.
bool Executor::prepare_special(Worker& self) {
  if ((self.special & Worker::kHasRested) != 0 && activity_hook_) activity_hook_();
  const bool sampled = (self.special & Worker::kMeasured) != 0;
  if (sampled) self.cpu_before = cpu_time_of(self.cpu_clock);
  self.special = 0;
  return sampled;
}

[[gnu::cold, gnu::noinline]] void Executor::note_exception(const Worker& self, const char* text) {
  // An executable that removed itself may be destroyed, with its name.
  self.group->node_.on_fault_("EXCEPTION", text, self.running != nullptr ? self.running->description() : std::string{});
}

[[gnu::always_inline]] inline void Executor::run(Worker& self, Executable& executable, Block* message,
                                                 MonotonicTime now) {
  const bool sampled = self.special != 0 && prepare_special(self);
  try {
    if (message != nullptr) {
      executable.execute_with(*message, now);
    } else {
      executable.execute(now);
    }
  } catch (const std::exception& e) { note_exception(self, e.what()); } catch (...) {
    note_exception(self, "a callback threw something other than a std::exception");
  }
  if (sampled) [[unlikely]]
    self.cpu_used = cpu_time_of(self.cpu_clock) - self.cpu_before;
}

[[gnu::always_inline]] inline void Executor::finish(Worker& self, MonotonicTime now) {
  CallbackGroup& group = *self.group;
  NodeGroups& node = group.node_;
  Executable* const executable = self.running;  // null: it removed itself, and may be destroyed
  --group.running_;
  --node.running_;
  if (self.unusual != 0) [[unlikely]]
    finish_unusual(self, node);
  // The node's backlog was ready before everything in the queue.
  if (!node.backlog_.empty()) [[unlikely]]
    ready_.prepend(node.backlog_);
  if (executable != nullptr) [[likely]] {
    if (executable->stats_ != nullptr) executable->stats_->duration.record(now - self.started);
    const auto wants_again = [&] {
      return executable->inbox_ != nullptr ? executable->inbox_->has_waiting() : executable->wants_again();
    };
    if (!executable->queued_.load(std::memory_order_relaxed) && wants_again() && !node.closed_) enqueue(*executable);
  }
  if (waiting_for_return_ != 0) [[unlikely]]
    note_return();
}

void Executor::finish_unusual(Worker& self, NodeGroups& node) {
  if ((self.unusual & Worker::kAlone) != 0) {
    node.alone_ = false;
    node.barred_ = node.next_transition_ != nullptr;
  }
  if ((self.unusual & Worker::kSampled) != 0) {
    ++node.samples_;
    node.sampled_cpu_ += self.cpu_used;
  }
  if ((self.unusual & Worker::kLate) != 0) self.state = Worker::State::Spare;
  self.unusual = 0;
}

// A spare takes the place of a callback that is late, or will be.
void Executor::hand_over(Worker& late) {
  auto spare = std::ranges::find(workers_, Worker::State::Spare, [](const auto& worker) { return worker->state; });
  late.unusual |= Worker::kLate;
  if (spare == workers_.end()) {
    try {
      start_worker();
      ++called_;
    } catch (const std::system_error&) {
      late.unusual ^= Worker::kLate;  // no thread can be started now; the next check retries
    }
    return;
  }
  call(**spare);
  futex_wake((*spare)->word, 1);
}

}  // namespace nacelle::runtime
