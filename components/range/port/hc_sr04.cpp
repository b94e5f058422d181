// SPDX-License-Identifier: Apache-2.0
#include "range/port/hc_sr04.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace nacelle::range {

Problem explain_echo_lines(const EchoSettings& settings, int os_code) {
  Problem problem{fmt::format("GPIO lines {} and {} of {}", settings.trigger_line, settings.echo_line, settings.chip),
                  fmt::format("cannot be used ({})", std::strerror(os_code)), "`gpioinfo` lists chips and lines"};
  switch (os_code) {
    case ENOENT:
    case ENODEV:
    case ENXIO: problem.what = "no such chip"; break;
    case EACCES:
    case EPERM:
      problem.what = "no permission to open the chip";
      problem.way_out = "`sudo usermod -aG gpio $USER`, then log in again";
      break;
    case EBUSY:
      problem.what = "in use by another program or driver";
      problem.way_out = "`gpioinfo` names it";
      break;
    case EINVAL: problem.what = "the chip has no such lines, or cannot do that with them"; break;
    default: break;
  }
  return problem;
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
