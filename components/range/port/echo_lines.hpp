// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::range {

/// Which lines an HC-SR04 is wired to.
struct EchoSettings {
  std::string chip = "/dev/gpiochip0";
  unsigned trigger_line = 23, echo_line = 24;  ///< Offsets on the chip; on a Raspberry Pi the BCM numbers.
};

/// A change of the echo line.
struct EchoEdge {
  bool rising = false;
  Duration at{};  ///< The kernel's time. Only differences mean something.
};

/// What both versions of libgpiod give: an output line, and an input line whose edges have the kernel's times.
///
/// Threads: one; interrupt() from any. Allocates: nothing after it was made.
class EchoLines {
 public:
  EchoLines() = default;
  EchoLines(const EchoLines&) = delete;
  EchoLines& operator=(const EchoLines&) = delete;
  virtual ~EchoLines() = default;

  /// Returns false when the line cannot be set: the chip is gone.
  [[nodiscard]] virtual bool set_trigger(bool high) = 0;
  enum class Wait : std::uint8_t { Edge, TimedOut, Woken, Lost };
  /// Waits for the next edge of the echo line. Edges that came before the wait are handed over first, in their order.
  [[nodiscard]] virtual Wait wait_edge(MonotonicTime deadline, EchoEdge& edge) = 0;
  /// Makes a waiting wait_edge() return at once.
  virtual void interrupt() noexcept = 0;
};

/// Opens the lines with the library that this was built with. Their chip stays open as long as they live.
/// Errors: a Problem that names chip and lines, and says what to do (rights, in use, no such chip, no libgpiod).
[[nodiscard]] Result<std::unique_ptr<EchoLines>, Problem> request_echo_lines(const EchoSettings& settings,
                                                                             const Clock& clock);
/// What errno of a failed request means.
[[nodiscard]] Problem explain_echo_lines(const EchoSettings& settings, int os_code);

}  // namespace nacelle::range
