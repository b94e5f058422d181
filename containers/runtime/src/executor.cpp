// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/executor.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>

#include "nacelle/base/log.hpp"

namespace nacelle::runtime {
namespace {

constexpr MonotonicTime kNever{Duration::max()};

// Whose callback runs on this thread, so that forget() from within it does not wait for itself.
thread_local Executable* running_here = nullptr;
thread_local Executor* executor_here = nullptr;

void name_this_thread(const std::string& name) { pthread_setname_np(pthread_self(), name.substr(0, 15).c_str()); }

void apply_policy(const ThreadPolicy& policy, const std::string& name) {
  const Logger log{"executor." + name};
  if (policy.priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = policy.priority;
    if (const int code = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); code != 0) {
      log.warn(
          "no SCHED_FIFO priority {} ({}): running at normal priority; allow it with LimitRTPRIO={} in the service or "
          "CAP_SYS_NICE",
          policy.priority, std::strerror(code), policy.priority);
    }
  }
  if (!policy.cpus.empty()) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : policy.cpus) {
      if (cpu >= 0 && cpu < CPU_SETSIZE) CPU_SET(cpu, &set);
    }
    if (const int code = pthread_setaffinity_np(pthread_self(), sizeof set, &set); code != 0) {
      log.warn("cannot be bound to its cpus ({}): runs on any; see `nproc`", std::strerror(code));
    }
  }
}

}  // namespace

// One thread of the executor: the owner of the queue, a late one, or a spare that waits to become the owner.
struct Executor::Worker {
  std::thread thread;
  Executable* running = nullptr;  // under the lock, as the rest
  CallbackGroup* group = nullptr;
  MonotonicTime started;
  bool reported_hung = false;
  std::atomic<std::uint32_t> turn{0};  // futex of a spare
};

void Executable::on_ready() noexcept {
  // Most messages of a busy stream find the thing queued already.
  if (queued_.load(std::memory_order_relaxed)) return;
  group_.executor().post(*this);
}

Executor::Executor(std::string name, const Clock& clock, ThreadPolicy policy)
    : name_(std::move(name)), clock_(clock), policy_(std::move(policy)), next_due_(kNever) {
  const std::lock_guard lock(mutex_);
  start_worker();
  owner_ = workers_.back().get();
  // The spare stands by from the start: the moment in which a callback overstays is a bad one to make a thread in. A thread of
  // a component's own has nobody else to serve.
  if (!policy_.own) start_worker();
}

Executor::~Executor() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_word_.fetch_add(1);
  futex_wake(wake_word_, std::numeric_limits<int>::max());
  for (auto& worker : workers_) {
    worker->turn.fetch_add(1);
    futex_wake(worker->turn, 1);
  }
  for (auto& worker : workers_) worker->thread.join();
}

void Executor::start_worker() {
  workers_.push_back(std::make_unique<Worker>());
  Worker& worker = *workers_.back();
  worker.thread = std::thread([this, &worker] { work(worker); });
}

void Executor::post(Executable& executable) noexcept {
  bool wake = false;
  {
    const std::lock_guard lock(mutex_);
    if (executable.queued_.load(std::memory_order_relaxed) || executable.group_.closed_) return;
    executable.queued_.store(true, std::memory_order_relaxed);
    append(executable);
    wake = sleeping_;
    sleeping_ = false;
  }
  if (wake) {
    wake_word_.fetch_add(1, std::memory_order_release);
    futex_wake(wake_word_, 1);
    if (activity_hook_) activity_hook_();
  }
}

void Executor::append(Executable& executable) {
  executable.next_ = nullptr;
  if (tail_ == nullptr) {
    head_ = tail_ = &executable;
  } else {
    tail_->next_ = &executable;
    tail_ = &executable;
  }
}

// The first ready thing whose group is free; those of a held group or of a busy one (its callback overstays) wait in the group's backlog.
Executable* Executor::pop() {
  while (head_ != nullptr) {
    Executable* const first = head_;
    head_ = first->next_;
    if (head_ == nullptr) tail_ = nullptr;
    first->next_ = nullptr;
    if (!first->group_.busy_ && !first->group_.held_) return first;
    Executable** last = &first->group_.backlog_;
    while (*last != nullptr) last = &(*last)->next_;
    *last = first;
  }
  return nullptr;
}

void Executor::add_timer(TimerBase& timer) {
  bool wake = false;
  {
    const std::lock_guard lock(mutex_);
    timer.due_ = clock_.now() + timer.period_;
    if (!timer.armed_) timers_.push_back(&timer);
    timer.armed_ = true;
    if (timer.due_ < next_due_) {
      next_due_ = timer.due_;
      wake = sleeping_;
      sleeping_ = false;
    }
  }
  if (wake) {
    wake_word_.fetch_add(1, std::memory_order_release);
    futex_wake(wake_word_, 1);
  }
}

void Executor::cancel_timer(TimerBase& timer) {
  const std::lock_guard lock(mutex_);
  if (!timer.armed_) return;
  timer.armed_ = false;
  std::erase(timers_, &timer);
}

bool Executor::is_armed(const TimerBase& timer) const {
  const std::lock_guard lock(mutex_);
  return timer.armed_;
}

void Executor::fire_due_timers(MonotonicTime now) {
  next_due_ = kNever;
  for (TimerBase* timer : timers_) {
    if (timer->due_ <= now) {
      // A late tick is not made up for: the next one is the next multiple of the period.
      const auto missed = (now - timer->due_) / timer->period_;
      timer->due_ += timer->period_ * (missed + 1);
      if (!timer->queued_.load(std::memory_order_relaxed) && timer->is_open() && !timer->group_.closed_) {
        timer->queued_.store(true, std::memory_order_relaxed);
        append(*timer);
      }
    }
    next_due_ = std::min(next_due_, timer->due_);
  }
}

void Executor::work(Worker& self) {
  name_this_thread(name_);
  apply_policy(policy_, name_);
  executor_here = this;
  for (;;) {
    const std::uint32_t turn = self.turn.load(std::memory_order_acquire);
    bool mine = false;
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
      mine = owner_ == &self;
    }
    if (mine) {
      run_as_owner(self);
    } else {
      futex_wait(self.turn, turn);
    }
  }
}

void Executor::run_as_owner(Worker& self) {
  mutex_.lock();
  while (owner_ == &self && !stopping_) {
    const MonotonicTime now = clock_.now();
    if (now >= next_due_) fire_due_timers(now);
    Executable* const next = pop();
    if (next == nullptr) {
      sleeping_ = true;
      const std::uint32_t word = wake_word_.load(std::memory_order_relaxed);
      const MonotonicTime until = next_due_;
      mutex_.unlock();
      if (until == kNever) {
        futex_wait(wake_word_, word);
      } else {
        futex_wait_until(wake_word_, word, until);
      }
      mutex_.lock();
      sleeping_ = false;
      continue;
    }
    CallbackGroup& group = next->group_;
    next->queued_.store(false, std::memory_order_relaxed);
    group.busy_ = true;
    self.running = next;
    self.group = &group;
    self.started = now;
    self.reported_hung = false;
    // A transition may open devices for seconds: nobody else is to notice, not even for handover_after.
    if (!policy_.own && next->may_take_long()) hand_over();
    mutex_.unlock();
    running_here = next;
    try {
      next->execute(now);
    } catch (const std::exception& e) { group.on_fault_("EXCEPTION", e.what()); } catch (...) {
      group.on_fault_("EXCEPTION", "a callback threw something that is no std::exception");
    }
    running_here = nullptr;
    mutex_.lock();
    finish(self, self.running, group);
  }
  mutex_.unlock();
}

// Under the lock. `executable` is null if it was forgotten from within its own callback: it may be gone.
void Executor::finish(Worker& self, Executable* executable, CallbackGroup& group) {
  self.running = nullptr;
  self.group = nullptr;
  group.busy_ = false;
  bool wake = false;
  const bool anything_before = head_ != nullptr;
  while (group.backlog_ != nullptr) {
    Executable* const waiting = group.backlog_;
    group.backlog_ = waiting->next_;
    append(*waiting);
  }
  if (executable != nullptr && !group.closed_ && !executable->queued_.load(std::memory_order_relaxed) &&
      executable->wants_again()) {
    executable->queued_.store(true, std::memory_order_relaxed);
    append(*executable);
  }
  // A late thread hands what its group has to the new owner, which may be asleep.
  if (owner_ != &self && !anything_before && head_ != nullptr && sleeping_) {
    sleeping_ = false;
    wake = true;
  }
  if (waiters_.load(std::memory_order_relaxed) != 0) {
    finished_word_.fetch_add(1, std::memory_order_release);
    futex_wake(finished_word_, std::numeric_limits<int>::max());
  }
  if (wake) {
    wake_word_.fetch_add(1, std::memory_order_release);
    futex_wake(wake_word_, 1);
  }
}

void Executor::unlink(Executable*& list, Executable& executable) {
  Executable** at = &list;
  while (*at != nullptr && *at != &executable) at = &(*at)->next_;
  if (*at != nullptr) *at = executable.next_;
}

void Executor::forget(Executable& executable) {
  waiters_.fetch_add(1);
  mutex_.lock();
  unlink(head_, executable);
  tail_ = head_;
  while (tail_ != nullptr && tail_->next_ != nullptr) tail_ = tail_->next_;
  unlink(executable.group_.backlog_, executable);
  executable.queued_.store(true, std::memory_order_relaxed);  // nobody queues it again
  for (;;) {
    Worker* busy = nullptr;
    for (const auto& worker : workers_) {
      if (worker->running == &executable) busy = worker.get();
    }
    if (busy == nullptr) break;
    if (running_here == &executable) {
      busy->running = nullptr;  // from within: it ends after us, and finish() must not touch it
      break;
    }
    const std::uint32_t word = finished_word_.load(std::memory_order_relaxed);
    mutex_.unlock();
    futex_wait(finished_word_, word);
    mutex_.lock();
  }
  mutex_.unlock();
  waiters_.fetch_sub(1);
}

void Executor::hold(CallbackGroup& group) {
  const std::lock_guard lock(mutex_);
  group.held_ = true;
}

void Executor::open(CallbackGroup& group) {
  bool wake = false;
  {
    const std::lock_guard lock(mutex_);
    group.held_ = false;
    while (group.backlog_ != nullptr) {
      Executable* const waiting = group.backlog_;
      group.backlog_ = waiting->next_;
      append(*waiting);
    }
    wake = sleeping_ && head_ != nullptr;
    if (wake) sleeping_ = false;
  }
  if (!wake) return;
  wake_word_.fetch_add(1, std::memory_order_release);
  futex_wake(wake_word_, 1);
  if (activity_hook_) activity_hook_();
}

// Under the lock. What is dropped stays marked as queued, so that nobody queues it again.
void Executor::drop_waiting(Executable*& list, const CallbackGroup& group) {
  Executable** at = &list;
  while (*at != nullptr) {
    Executable* const waiting = *at;
    if (&waiting->group_ != &group) {
      at = &waiting->next_;
      continue;
    }
    *at = waiting->next_;
    waiting->next_ = nullptr;
    waiting->on_dropped();
  }
}

// Under the lock: a spare thread becomes the owner of queue and timers.
void Executor::hand_over() {
  // Spares are threads whose callback has returned; there is rarely more than one.
  Worker* spare = nullptr;
  for (const auto& worker : workers_) {
    if (worker.get() != owner_ && worker->running == nullptr && worker->group == nullptr) spare = worker.get();
  }
  if (spare == nullptr) {
    start_worker();
    spare = workers_.back().get();
  }
  owner_ = spare;
  handovers_.fetch_add(1, std::memory_order_relaxed);
  spare->turn.fetch_add(1, std::memory_order_release);
  futex_wake(spare->turn, 1);
}

bool Executor::close(CallbackGroup& group, MonotonicTime deadline) {
  waiters_.fetch_add(1);
  mutex_.lock();
  group.closed_ = true;
  drop_waiting(head_, group);
  tail_ = head_;
  while (tail_ != nullptr && tail_->next_ != nullptr) tail_ = tail_->next_;
  drop_waiting(group.backlog_, group);
  bool done = !group.busy_ || (executor_here == this && running_here != nullptr && &running_here->group_ == &group);
  while (!done && clock_.now() < deadline) {
    const std::uint32_t word = finished_word_.load(std::memory_order_relaxed);
    mutex_.unlock();
    futex_wait_until(clock_, finished_word_, word, deadline);
    mutex_.lock();
    done = !group.busy_;
  }
  mutex_.unlock();
  waiters_.fetch_sub(1);
  return done;
}

void Executor::supervise(const Limits& limits) {
  CallbackGroup* hung = nullptr;
  Duration hung_for{};
  std::string hung_name;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    const MonotonicTime now = clock_.now();
    if (!policy_.own && owner_->running != nullptr && now - owner_->started > limits.handover_after) hand_over();
    for (const auto& worker : workers_) {
      if (worker->group == nullptr || worker->running == nullptr || worker->reported_hung ||
          worker->running->may_take_long())
        continue;
      if (now - worker->started <= limits.hang_after) continue;
      worker->reported_hung = true;
      hung = worker->group;
      hung_for = now - worker->started;
    }
  }
  // The group belongs to a node that cannot be destroyed while its callback runs, so it is safe outside the lock.
  if (hung != nullptr) {
    hung->on_fault_(
        "HUNG", fmt::format("a callback of {} has been running for {:.1f} s; its thread is given up, the others go on",
                            hung->name(), to_seconds(hung_for)));
  }
}

std::size_t Executor::thread_count() const {
  const std::lock_guard lock(mutex_);
  return workers_.size();
}

bool Executor::is_idle() const {
  const std::lock_guard lock(mutex_);
  if (head_ != nullptr) return false;
  return std::ranges::all_of(workers_, [](const auto& worker) { return worker->group == nullptr; });
}

}  // namespace nacelle::runtime
