// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "nacelle/base/bell.hpp"
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
  HungUp     ///< The other end is closed and nothing is left to read.
};

/// Waits until the descriptor can be read.
///
/// Bytes that came before a hang-up are Ready first. A deadline in the past looks once and does not wait.
/// Allocates: nothing.
[[nodiscard]] Wake wait_readable(int descriptor, Bell& bell, const Clock& clock, MonotonicTime deadline);

/// Waits until the descriptor takes bytes; TimedOut or HungUp otherwise.
[[nodiscard]] Wake wait_writable(int descriptor, const Clock& clock, MonotonicTime deadline);

}  // namespace nacelle::io
