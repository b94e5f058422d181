// SPDX-License-Identifier: Apache-2.0
// Compiled once without a mistake and once with each: see CMakeLists.txt.
#include <condition_variable>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle {

class Counter {
 public:
  void add() {
    const LockGuard lock(mutex_);
    add_locked();
    changed_.notify_all();
  }
  void wait_for_one() {
    UniqueLock lock(mutex_);
    changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return count_ != 0; });
    lock.unlock();
    lock.lock();
    count_ = 0;
  }
  int sum() const {
    auto all = all_.lock();
    int sum = 0;
    for (const int one : *all) sum += one;
    return sum;
  }

#if defined(MISTAKE_UNLOCKED)
  int look() const { return count_; }
#elif defined(MISTAKE_RELEASED)
  void forget() {
    UniqueLock lock(mutex_);
    lock.unlock();
    count_ = 0;
  }
#elif defined(MISTAKE_PREDICATE)
  void wait() {
    UniqueLock lock(mutex_);
    changed_.wait(lock.raw(), [this] { return count_ != 0; });
  }
#elif defined(MISTAKE_CALL)
  void add_twice() { add_locked(); }
#elif defined(MISTAKE_DANGLING)
  int first() const {
    for (const int& one : *all_.lock()) return one;
    return 0;
  }
#endif

 private:
  void add_locked() NACELLE_REQUIRES(mutex_) { ++count_; }

  mutable Mutex mutex_;
  std::condition_variable changed_;
  int count_ NACELLE_GUARDED_BY(mutex_) = 0;
  Guarded<std::vector<int>> all_;
};

}  // namespace nacelle
