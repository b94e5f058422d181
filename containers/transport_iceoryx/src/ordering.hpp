// SPDX-License-Identifier: Apache-2.0
#pragma once

// iceoryx's own counts and queues order what one side writes into a chunk before what the other reads, and the last read before the
// next use. The thread sanitizer does not see into Debian's library; these say to it what iceoryx does. Elsewhere they are nothing.
#ifdef __SANITIZE_THREAD__
extern "C" void __tsan_acquire(void*);  // NOLINT(bugprone-reserved-identifier): the sanitizer's names
extern "C" void __tsan_release(void*);  // NOLINT(bugprone-reserved-identifier)
#endif

namespace nacelle::transport_iceoryx {

/// Before a chunk is handed over: sent, or given back.
inline void hand_over(const void* chunk) {
#ifdef __SANITIZE_THREAD__
  __tsan_release(const_cast<void*>(chunk));
#else
  static_cast<void>(chunk);
#endif
}
/// After a chunk has been taken over: received, or lent.
inline void take_over(const void* chunk) {
#ifdef __SANITIZE_THREAD__
  __tsan_acquire(const_cast<void*>(chunk));
#else
  static_cast<void>(chunk);
#endif
}

}  // namespace nacelle::transport_iceoryx
