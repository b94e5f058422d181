// SPDX-License-Identifier: Apache-2.0
#pragma once

// Annotations for the thread sanitizer. iceoryx's counters and queues order the writes of one side to a chunk before
// the reads of the other, and the last read before the next use of the chunk. The sanitizer does not see this, because
// Debian's library is not instrumented. In other builds these functions do nothing.
#ifdef __SANITIZE_THREAD__
extern "C" void __tsan_acquire(void*);  // NOLINT(bugprone-reserved-identifier): the sanitizer's names
extern "C" void __tsan_release(void*);  // NOLINT(bugprone-reserved-identifier)
#endif

namespace nacelle::transport_iceoryx {

/// Call before a chunk is sent or given back.
inline void hand_over(const void* chunk) {
#ifdef __SANITIZE_THREAD__
  __tsan_release(const_cast<void*>(chunk));
#else
  static_cast<void>(chunk);
#endif
}
/// Call after a chunk was received or borrowed.
inline void take_over(const void* chunk) {
#ifdef __SANITIZE_THREAD__
  __tsan_acquire(const_cast<void*>(chunk));
#else
  static_cast<void>(chunk);
#endif
}

}  // namespace nacelle::transport_iceoryx
