// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// Lines of a GPIO chip that are used together.
struct GpioRequest {
  std::string chip = "/dev/gpiochip0";
  std::vector<unsigned> lines;       ///< Offsets on the chip, each once, 64 at most; on a Raspberry Pi the BCM numbers.
  std::string consumer = "nacelle";  ///< What `gpioinfo` shows.
  bool pulls_up = false;             ///< Inputs: with the pull-up of the chip, where it has one.
};

/// A change of an input line.
struct GpioEdge {
  unsigned line = 0;  ///< Index into GpioRequest::lines.
  bool rising = false;
  MonotonicTime at{};  ///< When the kernel saw it.
  // Both count from 1 on, and wrap; they count edges that were dropped since the memory was full, too.
  std::uint32_t number = 0;  ///< Of all edges of the line.
  /// Of all edges of the request, by the time of their interrupts: the kernel may hand over edges of different lines in another order. Two edges
  /// of a line in so short a time that the kernel makes one of them have a gap before them.
  std::uint32_t sequence = 0;
};

/// Output lines. They are low from the request on.
///
/// Threads: one. Allocates: nothing but in reopen().
class GpioOutputs {
 public:
  GpioOutputs() = default;
  GpioOutputs(const GpioOutputs&) = delete;
  GpioOutputs& operator=(const GpioOutputs&) = delete;
  virtual ~GpioOutputs() = default;

  /// Sets all lines at once: bit i is the i-th line of the request. Returns false if the chip is gone.
  [[nodiscard]] virtual bool set(std::uint64_t levels) = 0;
  /// Requests the lines of a chip that was gone anew. Returns false if it still is.
  [[nodiscard]] virtual bool reopen() = 0;
};

/// Input lines with the edges of all of them.
///
/// The kernel keeps the latest edges, 16 a line and at least kKept; if more came between two calls of take(), the oldest are lost, and the
/// numbers have a gap.
/// Threads: one. Allocates: nothing but in reopen().
class GpioInputs {
 public:
  GpioInputs() = default;
  GpioInputs(const GpioInputs&) = delete;
  GpioInputs& operator=(const GpioInputs&) = delete;
  virtual ~GpioInputs() = default;

  static constexpr std::size_t kKept = 1024;
  static constexpr std::size_t kBatch = 64;  ///< take() hands over so many at most.

  /// Returns the levels: bit i is the i-th line of the request. Nothing: the chip is gone.
  [[nodiscard]] virtual std::optional<std::uint64_t> levels() = 0;
  /// Returns edges that have come, those of each line in their order; empty if there are no more. Valid until the next call. Nothing: the chip is
  /// gone. Does not wait.
  [[nodiscard]] virtual std::optional<std::span<const GpioEdge>> take() = 0;
  /// As GpioOutputs::reopen(). Numbers begin anew.
  [[nodiscard]] virtual bool reopen() = 0;
};

/// Requests lines through the kernel's character device (its version 2, Linux 5.10 and later).
/// Errors: a Problem that names the chip and the lines, and says what to do (no such chip or line, no permission, in use).
[[nodiscard]] Result<std::unique_ptr<GpioOutputs>, Problem> request_gpio_outputs(const GpioRequest& request);
[[nodiscard]] Result<std::unique_ptr<GpioInputs>, Problem> request_gpio_inputs(const GpioRequest& request);
/// Returns what errno of a failed request means, by this or another way to the lines, and what to do. Pure.
[[nodiscard]] Problem explain_gpio(const GpioRequest& request, int os_code);

}  // namespace nacelle::io
