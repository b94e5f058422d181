// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/timer_queue.hpp"

namespace nacelle::runtime {

bool TimerQueue::comes_before(const TimerBase& a, const TimerBase& b) {
  return a.due_ != b.due_ ? a.due_ < b.due_ : a.order_ < b.order_;
}

void TimerQueue::set(std::size_t place, TimerBase& timer) {
  heap_[place] = &timer;
  timer.place_ = place;
}

// Moves the timer at this place up or down, to where its due time belongs.
void TimerQueue::settle(std::size_t place) {
  TimerBase& timer = *heap_[place];
  while (place > 0 && comes_before(timer, *heap_[(place - 1) / 2])) {
    set(place, *heap_[(place - 1) / 2]);
    place = (place - 1) / 2;
  }
  for (;;) {
    std::size_t child = 2 * place + 1;
    if (child >= heap_.size()) break;
    if (child + 1 < heap_.size() && comes_before(*heap_[child + 1], *heap_[child])) ++child;
    if (!comes_before(*heap_[child], timer)) break;
    set(place, *heap_[child]);
    place = child;
  }
  set(place, timer);
  next_due_ = heap_.front()->due_;
}

void TimerQueue::put(TimerBase& timer, MonotonicTime due) {
  timer.due_ = due;
  if (timer.place_ == TimerBase::kNotWaiting) {
    timer.order_ = added_++;
    heap_.push_back(&timer);
    timer.place_ = heap_.size() - 1;
  }
  settle(timer.place_);
}

void TimerQueue::remove(TimerBase& timer) {
  if (timer.place_ == TimerBase::kNotWaiting) return;
  const std::size_t place = timer.place_;
  TimerBase* const last = heap_.back();
  heap_.pop_back();
  timer.place_ = TimerBase::kNotWaiting;
  if (heap_.empty()) {
    next_due_ = kNever;
  } else if (place < heap_.size()) {
    set(place, *last);
    settle(place);
  } else {
    next_due_ = heap_.front()->due_;
  }
}

}  // namespace nacelle::runtime
