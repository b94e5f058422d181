// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <utility>

namespace nacelle {

/// A value that can only be reached while its lock is held.
///
/// `auto routes = routes_.lock(); routes->add(...)`: the lock ends with the variable. Keep its life short and never call
/// unknown code under it.
template <typename T>
class Guarded {
 public:
  class Locked {
   public:
    Locked(std::mutex& mutex, T& value) : lock_(mutex), value_(value) {}
    T* operator->() { return &value_; }
    T& operator*() { return value_; }
    /// For condition variables.
    std::unique_lock<std::mutex>& raw_lock() { return lock_; }

   private:
    std::unique_lock<std::mutex> lock_;
    T& value_;
  };

  Guarded() = default;
  template <typename... Args>
  explicit Guarded(std::in_place_t, Args&&... args) : value_(std::forward<Args>(args)...) {}

  [[nodiscard]] Locked lock() const { return Locked{mutex_, value_}; }

 private:
  mutable std::mutex mutex_;
  mutable T value_{};
};

}  // namespace nacelle
