// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <utility>

#include "nacelle/base/mutex.hpp"
#include "range/port/echo_lines.hpp"

namespace nacelle::range {

/// The lines of an HC-SR04 that a test plays: they answer each trigger with the pulse that the test has set. Waits move the test's clock and
/// never block.
/// Threads: any.
class ScriptedEchoLines final : public EchoLines {
 public:
  using Sleep = std::function<void(MonotonicTime until)>;
  explicit ScriptedEchoLines(const Clock& clock, Sleep sleep) : clock_(clock), sleep_(std::move(sleep)) {}

  /// How long the pulses are from now on; nothing: the sensor does not answer.
  void answer(std::optional<Duration> pulse);
  /// The chip is removed.
  void lose();
  [[nodiscard]] int triggers() const;

  [[nodiscard]] bool set_trigger(bool high) override;
  [[nodiscard]] Wait wait_edge(MonotonicTime deadline, EchoEdge& edge) override;
  void interrupt() noexcept override;

  /// From the end of the trigger to the pulse. Source: 8 cycles of 40 kHz, and what the sensor's processor needs.
  static constexpr Duration kBurst = 450us;

 private:
  const Clock& clock_;
  const Sleep sleep_;
  mutable Mutex mutex_;
  std::optional<Duration> pulse_ NACELLE_GUARDED_BY(mutex_) = Duration{};
  std::deque<EchoEdge> edges_ NACELLE_GUARDED_BY(mutex_);
  bool high_ NACELLE_GUARDED_BY(mutex_) = false;
  bool lost_ NACELLE_GUARDED_BY(mutex_) = false;
  bool woken_ NACELLE_GUARDED_BY(mutex_) = false;
  int triggers_ NACELLE_GUARDED_BY(mutex_) = 0;
};

}  // namespace nacelle::range
