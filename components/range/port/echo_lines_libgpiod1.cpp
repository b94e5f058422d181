// SPDX-License-Identifier: Apache-2.0
// The lines through libgpiod 1.6 (Debian 12).
#include <gpiod.h>

#include <cerrno>
#include <utility>

#include "nacelle/io/descriptor.hpp"
#include "range/port/echo_lines.hpp"

namespace nacelle::range {
namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }  // its lines too
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

class Lines final : public EchoLines {
 public:
  Lines(Chip chip, gpiod_line* trigger, gpiod_line* echo, const Clock& clock)
      : chip_(std::move(chip)), trigger_(trigger), echo_(echo), clock_(clock) {}
  bool set_trigger(bool high) override { return gpiod_line_set_value(trigger_, high ? 1 : 0) == 0; }
  Wait wait_edge(MonotonicTime deadline, EchoEdge& edge) override {
    switch (io::wait_readable(gpiod_line_event_get_fd(echo_), bell_, clock_, deadline)) {
      case io::Wake::TimedOut: return Wait::TimedOut;
      case io::Wake::Woken: return Wait::Woken;
      case io::Wake::HungUp: return Wait::Lost;
      case io::Wake::Ready: break;
    }
    gpiod_line_event event{};
    if (gpiod_line_event_read(echo_, &event) != 0) return Wait::Lost;
    edge = {event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
            std::chrono::seconds{event.ts.tv_sec} + Duration{event.ts.tv_nsec}};
    return Wait::Edge;
  }
  void interrupt() noexcept override { bell_.ring(); }

 private:
  Chip chip_;
  gpiod_line* trigger_;
  gpiod_line* echo_;
  const Clock& clock_;
  Bell bell_;
};

}  // namespace

Result<std::unique_ptr<EchoLines>, Problem> request_echo_lines(const EchoSettings& settings, const Clock& clock) {
  Chip chip{gpiod_chip_open(settings.chip.c_str())};
  if (!chip) return err(explain_echo_lines(settings, errno));
  gpiod_line* const trigger = gpiod_chip_get_line(chip.get(), settings.trigger_line);
  gpiod_line* const echo = trigger != nullptr ? gpiod_chip_get_line(chip.get(), settings.echo_line) : nullptr;
  if (echo == nullptr || gpiod_line_request_output(trigger, "nacelle-range", 0) != 0 ||
      gpiod_line_request_both_edges_events(echo, "nacelle-range") != 0) {
    return err(explain_echo_lines(settings, errno));
  }
  return std::unique_ptr<EchoLines>{std::make_unique<Lines>(std::move(chip), trigger, echo, clock)};
}

}  // namespace nacelle::range
