// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle {

/// A bell that one thread rings to wake another out of a wait (an eventfd).
class Bell {
 public:
  /// Errors: std::system_error if the process has no descriptor left; in a component's transition that is its failure.
  Bell();
  Bell(const Bell&) = delete;
  Bell& operator=(const Bell&) = delete;
  ~Bell();
  /// Its descriptor can be read from then on. Threads: any; also from a signal handler.
  void ring() noexcept;
  /// True if it had rung; it is silent afterwards.
  bool silence() noexcept;
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  const int descriptor_;
};

}  // namespace nacelle
