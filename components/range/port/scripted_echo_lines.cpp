// SPDX-License-Identifier: Apache-2.0
#include "range/port/scripted_echo_lines.hpp"

namespace nacelle::range {

void ScriptedEchoLines::answer(std::optional<Duration> pulse) {
  const LockGuard lock{mutex_};
  pulse_ = pulse;
}

void ScriptedEchoLines::lose() {
  const LockGuard lock{mutex_};
  lost_ = true;
}

int ScriptedEchoLines::triggers() const {
  const LockGuard lock{mutex_};
  return triggers_;
}

bool ScriptedEchoLines::set_trigger(bool high) {
  const LockGuard lock{mutex_};
  if (lost_) return false;
  const bool ended = high_ && !high;
  high_ = high;
  if (!ended) return true;
  ++triggers_;
  if (!pulse_) return true;
  const Duration begin = clock_.now().since_origin + kBurst;
  edges_.push_back({true, begin});
  edges_.push_back({false, begin + *pulse_});
  return true;
}

EchoLines::Wait ScriptedEchoLines::wait_edge(MonotonicTime deadline, EchoEdge& edge) {
  const LockGuard lock{mutex_};
  if (lost_) return Wait::Lost;
  if (std::exchange(woken_, false)) return Wait::Woken;
  if (edges_.empty() || MonotonicTime{edges_.front().at} > deadline) {
    sleep_(deadline);
    return Wait::TimedOut;
  }
  edge = edges_.front();
  edges_.pop_front();
  sleep_(MonotonicTime{edge.at});
  return Wait::Edge;
}

void ScriptedEchoLines::interrupt() noexcept {
  const LockGuard lock{mutex_};
  woken_ = true;
}

}  // namespace nacelle::range
