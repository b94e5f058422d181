// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// Owns one file descriptor and closes it.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();

  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }

 private:
  int number_ = -1;
};

/// What ended a wait.
enum class Wake : std::uint8_t {
  Ready,     ///< The descriptor can be read (or written) without waiting.
  TimedOut,  ///< The deadline came.
  Woken,     ///< The bell rang.
  HungUp     ///< The other end is gone and nothing is left to read.
};

/// A bell that one thread rings to wake another out of a wait (an eventfd).
class Bell {
 public:
  /// Errors: std::system_error if the process has no descriptor left; in a component's transition that is its failure.
  Bell();
  /// Threads: any; also from a signal handler.
  void ring() noexcept;
  /// True if it had rung; it is silent afterwards.
  bool silence() noexcept;
  [[nodiscard]] int descriptor() const { return event_.number(); }

 private:
  Descriptor event_;
};

/// Waits until the descriptor can be read.
///
/// Bytes that came before a hang-up are Ready first. A deadline in the past looks once and does not wait.
/// Allocates: nothing.
[[nodiscard]] Wake wait_readable(int descriptor, Bell& bell, const Clock& clock, MonotonicTime deadline);

/// Waits until the descriptor takes bytes; TimedOut or HungUp otherwise.
[[nodiscard]] Wake wait_writable(int descriptor, const Clock& clock, MonotonicTime deadline);

}  // namespace nacelle::io
