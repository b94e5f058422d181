// SPDX-License-Identifier: Apache-2.0
#include "range/port/hc_sr04.hpp"

#include <algorithm>
#include <ctime>

#include "nacelle/io/gpio_lines.hpp"

namespace nacelle::range {

Problem explain_echo_lines(const EchoSettings& settings, int os_code) {
  return io::explain_gpio({settings.chip, {settings.trigger_line, settings.echo_line}}, os_code);
}

Result<Duration, EchoFault> HcSr04::measure() {
  EchoEdge edge;
  std::optional<Duration> begin;
  bool triggered = false;
  MonotonicTime deadline = clock_.now();  // first the edges of a pulse that ended after its own measurement
  for (;;) {
    switch (lines_.wait_edge(deadline, edge)) {
      case EchoLines::Wait::Lost: return err(EchoFault::Lost);
      case EchoLines::Wait::Woken: return err(EchoFault::Woken);
      case EchoLines::Wait::Edge:
        is_high_ = edge.rising;
        if (!triggered) continue;
        if (!edge.rising && begin) return std::clamp(edge.at - *begin, Duration::zero(), kNoObstacle);
        if (edge.rising) {
          begin = edge.at;
          deadline = clock_.now() + kNoObstacle;
        }
        continue;
      case EchoLines::Wait::TimedOut: break;
    }
    if (is_high_) return kNoObstacle;
    if (triggered) return err(EchoFault::NoPulse);
    if (!lines_.set_trigger(true)) return err(EchoFault::Lost);
    timespec pulse{0, kTriggerPulse.count()};
    ::nanosleep(&pulse, nullptr);  // a longer pulse does no harm: the burst leaves when it ends
    if (!lines_.set_trigger(false)) return err(EchoFault::Lost);
    triggered = true;
    deadline = clock_.now() + kLongestAnswer;
  }
}

}  // namespace nacelle::range
