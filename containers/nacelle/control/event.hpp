// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::control {

/// What one thread uses to wake another that polls (an eventfd). Threads: any.
class Event {
 public:
  /// Errors: std::system_error if the process has no descriptor left.
  Event();
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  ~Event();

  /// Readable from then on. Async-signal-safe.
  void set() noexcept;
  void clear() noexcept;
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  const int descriptor_;
};

}  // namespace nacelle::control
