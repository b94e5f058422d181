// SPDX-License-Identifier: Apache-2.0
#include "scheduler.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace nacelle::model {

thread_local std::size_t Scheduler::me_ = 0;

Scheduler::Scheduler(unsigned seed) : seed_(seed), random_(seed) {
  // Some runs change threads at every step, some seldom: both find what the other does not.
  stickiness_ = 1U << choose(5);
  current_ = this;
  me_ = add();
}

Scheduler::~Scheduler() { current_ = nullptr; }

MonotonicTime Scheduler::now() const {
  now_ += Duration{random_() % 2000};
  return now_;
}

std::size_t Scheduler::add() {
  const std::lock_guard lock(mutex_);  // a thread that has just started already looks at the list
  all_.push_back(std::make_unique<Participant>());
  return all_.size() - 1;
}

void Scheduler::begin(std::size_t id) {
  me_ = id;
  std::unique_lock lock(mutex_);
  all_[id]->turn.wait(lock, [&] { return running_ == id; });
}

void Scheduler::end(std::size_t id) {
  std::unique_lock lock(mutex_);
  all_[id]->done = true;
  all_[id]->runnable = false;
  release(all_[id].get(), 1);
  go_on(lock);
}

// Under the lock: chooses the next thread, and returns when that is the calling one (or at once if it is done).
void Scheduler::go_on(std::unique_lock<std::mutex>& lock) {
  std::vector<std::size_t> ready;
  for (;;) {
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (all_[i]->runnable) ready.push_back(i);
    }
    if (!ready.empty()) break;
    // Everybody waits: time passes until the first deadline.
    Participant* next = nullptr;
    for (const auto& one : all_) {
      if (!one->done && (next == nullptr || one->until < next->until)) next = one.get();
    }
    if (next == nullptr || next->until == kForEver) {
      std::fprintf(stderr, "seed %u: a wake-up was lost, all threads wait for ever:\n", seed_);
      for (std::size_t i = 0; i < all_.size(); ++i) {
        if (!all_[i]->done) std::fprintf(stderr, "  thread %zu waits for a %s\n", i, all_[i]->kind);
      }
      std::_Exit(1);
    }
    now_ = std::max(now_, next->until);
    next->runnable = true;
  }
  const bool may_stay = all_[me_]->runnable && stickiness_ > 1 && random_() % stickiness_ != 0;
  running_ = may_stay ? me_ : ready[random_() % ready.size()];
  if (running_ == me_) return;
  all_[running_]->turn.notify_one();
  if (all_[me_]->done) return;
  const std::size_t me = me_;
  all_[me]->turn.wait(lock, [&] { return running_ == me; });
}

void Scheduler::step() {
  std::unique_lock lock(mutex_);
  go_on(lock);
}

void Scheduler::block(const void* on, const char* kind, MonotonicTime until) {
  std::unique_lock lock(mutex_);
  Participant& self = *all_[me_];
  self.waits_for = on;
  self.kind = kind;
  self.until = until;
  self.runnable = false;
  go_on(lock);
  self.waits_for = nullptr;
  self.until = kForEver;
}

void Scheduler::release(const void* on, int count) {
  std::vector<Participant*> waiting;
  for (const auto& one : all_) {
    if (one->waits_for == on && !one->runnable && !one->done) waiting.push_back(one.get());
  }
  std::shuffle(waiting.begin(), waiting.end(), random_);
  for (Participant* one : waiting) {
    if (count-- <= 0) break;
    one->runnable = true;
  }
}

void Scheduler::sleep(Duration how_long) { block(this, "moment", now_ + how_long); }

void Scheduler::wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, MonotonicTime deadline) {
  step();
  // Seldom, a wait returns without a reason, as futex(2) may.
  if (word.load() != expected || random_() % 64 == 0) return;
  block(&word, "wake-up", deadline);
}

void Scheduler::wake(const std::atomic<std::uint32_t>& word, int count) {
  step();
  release(&word, count);
}

void Scheduler::lock(bool& taken) {
  step();
  while (taken) block(&taken, "lock", kForEver);
  taken = true;
}

void Scheduler::unlock(bool& taken) {
  taken = false;
  release(&taken, 1);
  step();
}

void Thread::join() {
  Scheduler& scheduler = Scheduler::current();
  while (!scheduler.all_[id_]->done) scheduler.block(scheduler.all_[id_].get(), "thread", kForEver);
  thread_.join();
}

}  // namespace nacelle::model
