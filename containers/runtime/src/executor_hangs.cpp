// SPDX-License-Identifier: Apache-2.0
// Operations of other threads on an executor's queue and threads; running executables is in executor.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "executor_thread.hpp"
#include "executor_worker.hpp"
#include "nacelle/base/expect.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::runtime {

void ReadyList::prepend(ReadyList& other) {
  if (other.empty()) return;
  if (empty()) end_ = other.end_;
  *other.end_ = first_;
  first_ = other.first_;
  other.first_ = nullptr;
  other.end_ = &other.first_;
}

void ReadyList::remove(const Executable& executable) {
  for (Executable** at = &first_; *at != nullptr; at = &(*at)->next_) {
    if (*at != &executable) continue;
    *at = executable.next_;
    if (end_ == &executable.next_) end_ = at;
    return;
  }
}

void Executable::execute_with(Block&, MonotonicTime) {
  NACELLE_EXPECT(inbox_ == nullptr, "what takes from a queue runs with its messages");
}

std::string Executable::description() const {
  return *label_name_ == '\0' ? std::string{label_} : std::string{label_} + " " + label_name_;
}

Executor::RunsHere Executor::runs_here() noexcept {
  const Worker* const here = Worker::here;
  if (here == nullptr || here->group == nullptr) return {};
  RunsHere now{.node = here->group->node_.name_.c_str()};
  if (here->running != nullptr) {
    now.what = here->running->label_;
    now.name = here->running->label_name_;
  }
  return now;
}

NodeGroups::NodeGroups(Executor& executor, std::string name, OnFault on_fault)
    : executor_(executor),
      name_(std::move(name)),
      on_fault_(std::move(on_fault)),
      one_at_a_time_(executor.serving() == 1) {}

NodeGroups::~NodeGroups() { static_cast<void>(executor_.close(*this, MonotonicTime{})); }

// Timers of one executor that start while their node is not open, or its lifecycle gate is closed, tick at common
// multiples of their period, so that many of them share one wake-up. They are never early, and at most a period late.
// Slow timers are excluded: they wake rarely, and users would notice the delay of an "every 10 s".
MonotonicTime Executor::first_due(const TimerBase& timer, MonotonicTime now) const {
  constexpr Duration kSlow = 1s;
  const MonotonicTime due = now + timer.period_;
  const bool is_seen = timer.started_ || (timer.home_.opened_ && timer.open_);
  if (is_seen || timer.period_ > kSlow) return due;
  const Duration beyond = (due - epoch_) % timer.period_;
  return beyond == Duration::zero() ? due : due + (timer.period_ - beyond);
}

void Executor::add_timer(TimerBase& timer) {
  Worker* to_wake = nullptr;
  {
    const LockGuard lock(mutex_);
    timer.due_ = first_due(timer, clock_.now());
    timer.started_ = true;
    timer.armed_ = true;
    if (timer.open_) timers_.put(timer, timer.due_);
    to_wake = next_to_call();
  }
  if (to_wake != nullptr) futex_wake(to_wake->word, 1);
}

void Executor::cancel_timer(TimerBase& timer) {
  const LockGuard lock(mutex_);
  timer.armed_ = false;
  timers_.remove(timer);
}

void Executor::set_timer_open(TimerBase& timer, bool open) {
  Worker* to_wake = nullptr;
  {
    const LockGuard lock(mutex_);
    if (timer.open_ == open) return;
    timer.open_ = open;
    if (!open) {
      timers_.remove(timer);
    } else if (timer.armed_) {
      const MonotonicTime now = clock_.now();
      if (timer.due_ <= now) timer.due_ += timer.period_ * ((now - timer.due_) / timer.period_ + 1);
      timers_.put(timer, timer.due_);
      to_wake = next_to_call();
    }
  }
  if (to_wake != nullptr) futex_wake(to_wake->word, 1);
}

bool Executor::is_armed(const TimerBase& timer) const {
  const LockGuard lock(mutex_);
  return timer.armed_;
}

MonotonicTime Executor::next_timer() const {
  const LockGuard lock(mutex_);
  return timers_.next_due();
}

std::uint64_t Executor::skipped(const TimerBase& timer) const {
  const LockGuard lock(mutex_);
  return timer.skipped_;
}

// Under the lock. Wakes here and not after it, because the waiting thread may destroy the executable that has just
// returned.
void Executor::note_return() {
  return_word_.fetch_add(1, std::memory_order_release);
  futex_wake(return_word_, std::numeric_limits<int>::max());
}

void Executor::forget(Executable& executable) {
  Worker* to_wake = nullptr;
  mutex_.lock();
  NodeGroups& node = executable.home_;
  if (executable.queued_.load(std::memory_order_relaxed)) {
    ready_.remove(executable);
    node.backlog_.remove(executable);
  }
  executable.queued_.store(true, std::memory_order_relaxed);  // prevents that it is queued again
  if (node.next_transition_ == &executable) {
    node.next_transition_ = nullptr;
    node.barred_ = !node.opened_ || node.alone_;
    ready_.prepend(node.backlog_);
    to_wake = next_to_call();
  }
  ++waiting_for_return_;
  for (;;) {
    bool runs = false;
    for (const auto& worker : workers_) {
      if (worker->running != &executable) continue;
      if (worker.get() == Worker::here) {
        worker->running =
            nullptr;  // called from within its own run: it ends after this, and finish() must not touch it
      } else {
        runs = true;
      }
    }
    if (!runs) break;
    const std::uint32_t word = return_word_.load(std::memory_order_relaxed);
    mutex_.unlock();
    if (to_wake != nullptr) futex_wake(to_wake->word, 1);
    to_wake = nullptr;
    futex_wait(return_word_, word);
    mutex_.lock();
  }
  --waiting_for_return_;
  mutex_.unlock();
  if (to_wake != nullptr) futex_wake(to_wake->word, 1);
}

void Executor::open(NodeGroups& node) {
  Worker* to_wake = nullptr;
  {
    const LockGuard lock(mutex_);
    node.opened_ = true;
    node.next_transition_ = nullptr;  // it is in the backlog, and will be checked again
    node.barred_ = false;
    ready_.prepend(node.backlog_);
    to_wake = next_to_call();
  }
  if (to_wake != nullptr) futex_wake(to_wake->word, 1);
}

bool Executor::close(NodeGroups& node, MonotonicTime deadline) {
  const LockGuard lock(mutex_);
  node.closed_ = true;
  node.next_transition_ = nullptr;
  ReadyList others;
  ready_.prepend(node.backlog_);
  while (Executable* const waiting = ready_.pop_front()) {
    if (&waiting->home_ != &node) {
      others.push_back(*waiting);
      continue;
    }
    waiting->queued_.store(false, std::memory_order_relaxed);
    waiting->discard();
  }
  ready_.prepend(others);
  const Worker* const here = Worker::here;
  const bool from_within = here != nullptr && here->group != nullptr && &here->group->node_ == &node;
  const auto is_quiet = [&] { return node.pins_ == 0 && node.running_ == (from_within ? 1U : 0U); };
  ++waiting_for_return_;
  while (!is_quiet() && clock_.now() < deadline) {
    const std::uint32_t word = return_word_.load(std::memory_order_relaxed);
    mutex_.unlock();
    futex_wait_until(return_word_, word, deadline);
    mutex_.lock();
  }
  --waiting_for_return_;
  return is_quiet();
}

Duration Executor::supervise(const Limits& limits) {
  NodeGroups* hung = nullptr;
  Duration hung_for{};
  std::string hung_in;
  Duration next = Duration::max();
  {
    const LockGuard lock(mutex_);
    if (stopping_) return next;
    const MonotonicTime now = clock_.now();
    // By index, because hand_over() may add a thread.
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      Worker& worker = *workers_[i];
      if (worker.group == nullptr) continue;
      const Duration ran = now - worker.started;
      if (hands_over_ && (worker.unusual & Worker::kLate) == 0) {
        if (ran > limits.handover_after) {
          hand_over(worker);
          handovers_.fetch_add(1, std::memory_order_relaxed);
        } else {
          next = std::min(next, limits.handover_after - ran);
        }
      }
      if ((worker.unusual & Worker::kReportedHung) != 0) continue;
      const bool alone = (worker.unusual & Worker::kAlone) != 0;
      const Duration limit = !alone                      ? limits.hang_after
                             : worker.running != nullptr ? worker.running->time_limit()
                                                         : Duration::max();
      if (ran <= limit) {
        next = std::min(next, limit - ran);
      } else if (hung != nullptr) {
        next = Duration::zero();  // one at a time
      } else {
        worker.unusual |= Worker::kReportedHung;
        hung = &worker.group->node_;
        hung_for = ran;
        if (worker.running != nullptr) hung_in = worker.running->description();
        ++hung->pins_;  // the callback may return at any moment, and its node must exist until the fault is reported
      }
    }
  }
  if (hung == nullptr) return next;
  hung->on_fault_(
      "HUNG",
      fmt::format("a callback of {} has been running for {:.1f} s; its thread is abandoned, the others continue",
                  hung->name(), to_seconds(hung_for)),
      std::move(hung_in));
  const LockGuard lock(mutex_);
  --hung->pins_;
  if (waiting_for_return_ != 0) note_return();
  return next;
}

bool Executor::has_stalled() {
  const LockGuard lock(mutex_);
  if (stopping_) return false;
  MonotonicTime last_start{};
  for (const auto& worker : workers_) last_start = std::max(last_start, worker->started);
  // The threads of a component's own executor may all be in a callback, which hangs at worst. A late callback of the shared
  // executor has lost the queue; if no thread could take over, the others do wait.
  const bool is_busy =
      policy_.own && std::ranges::all_of(workers_, [](const auto& worker) { return worker->group != nullptr; });
  const bool waits = !is_busy && (!ready_.empty() || timers_.next_due() <= clock_.now());
  const bool stalled = waits && was_waiting_ && last_start == last_start_seen_;
  was_waiting_ = waits;
  last_start_seen_ = last_start;
  return stalled;
}

std::string Executor::why_not_wait(const NodeGroups& node, const CallbackGroup* group) const {
  const Worker* const here = Worker::here;
  if (here == nullptr || &here->executor != this || here->group == nullptr) return {};
  const LockGuard lock(mutex_);
  const NodeGroups& mine = here->group->node_;
  const bool alone = (here->unusual & Worker::kAlone) != 0, late = (here->unusual & Worker::kLate) != 0;
  std::string what;
  if (&mine == &node && (group == nullptr || alone)) {
    what = alone ? "a lifecycle transition runs alone in its node" : "a transition waits for all callbacks of its node";
  } else if (group == here->group && group->type() == CallbackGroupType::MutuallyExclusive) {
    what = "callbacks of one mutually exclusive group run one at a time";
  } else if (serving() == 1 && (!late || &mine == &node)) {
    what = fmt::format("executor '{}' has one thread", name_);
  } else {
    return {};
  }
  return fmt::format(
      "a callback of {} would wait for itself: {}; do not wait in a callback, or wait in a thread of your own",
      mine.name(), what);
}

std::string Executor::why_not_wait_for(const CallbackGroup& group) const { return why_not_wait(group.node_, &group); }
std::string Executor::why_not_wait_for(const NodeGroups& node) const { return why_not_wait(node, nullptr); }

std::size_t Executor::thread_count() const {
  const LockGuard lock(mutex_);
  return workers_.size();
}

bool Executor::is_idle() const {
  const LockGuard lock(mutex_);
  if (!ready_.empty()) return false;
  return std::ranges::all_of(workers_, [](const auto& worker) { return worker->group == nullptr; });
}

void Executor::report_threads(std::vector<ThreadReport>& out, std::size_t& used) const {
  const LockGuard lock(mutex_);
  for (const auto& worker : workers_) {
    if (worker->thread_id == 0) continue;  // not started yet
    if (used == out.size()) out.emplace_back();
    ThreadReport& row = out[used++];
    row.executor = name_;
    row.thread_id = worker->thread_id;
    row.state = (worker->unusual & Worker::kLate) != 0  ? "late"
                : worker->state == Worker::State::Spare ? "spare"
                                                        : "serving";
    row.cpu = cpu_time_of(worker->cpu_clock);
  }
}

void Executor::report_load(const NodeGroups& node, LoadReport& out) const {
  const LockGuard lock(mutex_);
  out.node = node.name_;
  out.callbacks = node.planned_ - node.until_sample_;
  out.samples = node.samples_;
  out.executor = name_;
  out.own_threads = policy_.own;
  out.thread_cpu = Duration::zero();
  for (const auto& worker : workers_) {
    if (policy_.own && worker->thread_id != 0) out.thread_cpu += cpu_time_of(worker->cpu_clock);
  }
  out.cpu = node.samples_ == 0 ? Duration::zero()
                               : Duration{static_cast<Duration::rep>(static_cast<double>(node.sampled_cpu_.count()) /
                                                                     static_cast<double>(node.samples_) *
                                                                     static_cast<double>(out.callbacks))};
}

}  // namespace nacelle::runtime
