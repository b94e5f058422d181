// SPDX-License-Identifier: Apache-2.0
// The queue of a proxy for a reader in another process, and the feedback to it from that reader's own queue.

#include "reader_queue.hpp"

#include "nacelle/base/mutex.hpp"

namespace nacelle::runtime {

Block* ReaderQueue::look() {
  const LockGuard lock(*mutex_);
  if (looked_at_ == waiting_.load(std::memory_order_relaxed)) return nullptr;
  Block* const block = ring_[(head_ + looked_at_++) & mask_];
  add_reference(*block);
  return block;
}

void ReaderQueue::release(std::uint64_t messages) {
  for (; messages != 0; --messages) {
    Block* block = nullptr;
    {
      const LockGuard lock(*mutex_);
      if (released_early_ != 0) {
        --released_early_;
        continue;
      }
      if (looked_at_ == 0) return;
      block = pop();
      --released_early_;
    }
    drop_reference(*block);
  }
}

void ReaderQueue::forget_seen() {
  const LockGuard lock(*mutex_);
  seen_.clear();
}

void ReaderQueue::note_lost(const ReaderCounters& losses) {
  {
    const LockGuard lock(*mutex_);
    counters_.received += losses.overwritten + losses.expired;
    counters_.overwritten += losses.overwritten;
    counters_.full += losses.full;
    counters_.expired += losses.expired;
    counters_.inactive += losses.inactive;
  }
  if (spec_.tells_lost && losses.overwritten + losses.full + losses.expired != 0) tell();
}

}  // namespace nacelle::runtime
