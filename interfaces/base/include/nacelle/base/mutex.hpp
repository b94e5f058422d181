// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

#include "nacelle/base/thread_safety.hpp"

namespace nacelle {

/// std::mutex with the annotations that libstdc++'s lacks. Its size and its instructions are the same.
///
/// Name it in the members that it guards: `int count_ NACELLE_GUARDED_BY(mutex_) = 0;`.
class NACELLE_CAPABILITY("mutex") Mutex {
 public:
  void lock() NACELLE_ACQUIRE() { mutex_.lock(); }
  void unlock() NACELLE_RELEASE() { mutex_.unlock(); }

 private:
  friend class UniqueLock;
  std::mutex mutex_;
};
static_assert(sizeof(Mutex) == sizeof(std::mutex));

/// Holds a lock as long as it lives, as std::lock_guard does.
template <typename Lock>
class NACELLE_SCOPED_CAPABILITY [[nodiscard]] LockGuard {
 public:
  explicit LockGuard(Lock& lock) NACELLE_ACQUIRE(lock) : lock_(lock) { lock_.lock(); }
  ~LockGuard() NACELLE_RELEASE() { lock_.unlock(); }
  LockGuard(const LockGuard&) = delete;
  LockGuard& operator=(const LockGuard&) = delete;

 private:
  Lock& lock_;
};

/// A LockGuard that can be released early, taken again, and waited with.
class NACELLE_SCOPED_CAPABILITY [[nodiscard]] UniqueLock {
 public:
  explicit UniqueLock(Mutex& mutex) NACELLE_ACQUIRE(mutex) : lock_(mutex.mutex_) {}
  ~UniqueLock() NACELLE_RELEASE() = default;
  UniqueLock(const UniqueLock&) = delete;
  UniqueLock& operator=(const UniqueLock&) = delete;

  void lock() NACELLE_ACQUIRE() { lock_.lock(); }
  void unlock() NACELLE_RELEASE() { lock_.unlock(); }
  /// For std::condition_variable. A predicate that reads what the lock guards says so:
  /// `changed_.wait(lock.raw().raw(), [this]() NACELLE_REQUIRES(mutex_) { return done_; });`.
  [[nodiscard]] std::unique_lock<std::mutex>& raw() { return lock_; }

 private:
  std::unique_lock<std::mutex> lock_;
};

}  // namespace nacelle
