// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "nacelle/base/mutex.hpp"

namespace nacelle {

/// A value that can only be reached while its lock is held.
///
/// `auto routes = routes_.lock(); routes->add(...)`: the lock ends with the variable. Keep its life short and never call
/// unknown code under it. clang rejects a reference that outlives its lock: `for (const Route& route : *routes_.lock())`.
template <typename T>
class Guarded {
 public:
  class Locked {
   public:
    Locked(Mutex& mutex, T& value) : lock_(mutex), value_(value) {}
    T* operator->() NACELLE_LIFETIME_BOUND { return &value_; }
    T& operator*() NACELLE_LIFETIME_BOUND { return value_; }

   private:
    LockGuard<Mutex> lock_;
    T& value_;
  };

  Guarded() = default;
  template <typename... Args>
  explicit Guarded(std::in_place_t, Args&&... args) : value_(std::forward<Args>(args)...) {}

  // Not checked: it takes the address of the value before the lock, which what it returns then takes.
  [[nodiscard]] Locked lock() const NACELLE_EXCLUDES(mutex_) NACELLE_NOT_CHECKED { return Locked{mutex_, value_}; }

 private:
  mutable Mutex mutex_;
  mutable T value_ NACELLE_GUARDED_BY(mutex_){};
};

}  // namespace nacelle
