// SPDX-License-Identifier: Apache-2.0
// The lines through libgpiod 2 (Debian 13).
#include <gpiod.h>

#include <cerrno>
#include <utility>

#include "nacelle/io/descriptor.hpp"
#include "range/port/echo_lines.hpp"

namespace nacelle::range {
namespace {

template <auto kFree>
struct Free {
  template <typename T>
  void operator()(T* thing) const {
    kFree(thing);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using LineSettings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;
using EventBuffer = std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>>;

class Lines final : public EchoLines {
 public:
  Lines(Request request, EventBuffer events, unsigned trigger, const Clock& clock)
      : request_(std::move(request)), events_(std::move(events)), trigger_(trigger), clock_(clock) {}
  bool set_trigger(bool high) override {
    return gpiod_line_request_set_value(request_.get(), trigger_,
                                        high ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE) == 0;
  }
  Wait wait_edge(MonotonicTime deadline, EchoEdge& edge) override {
    switch (io::wait_readable(gpiod_line_request_get_fd(request_.get()), bell_, clock_, deadline)) {
      case io::Wake::TimedOut: return Wait::TimedOut;
      case io::Wake::Woken: return Wait::Woken;
      case io::Wake::HungUp: return Wait::Lost;
      case io::Wake::Ready: break;
    }
    if (gpiod_line_request_read_edge_events(request_.get(), events_.get(), 1) != 1) return Wait::Lost;
    gpiod_edge_event* const event = gpiod_edge_event_buffer_get_event(events_.get(), 0);
    edge = {gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
            Duration{static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event))}};
    return Wait::Edge;
  }
  void interrupt() noexcept override { bell_.ring(); }

 private:
  Request request_;
  EventBuffer events_;
  const unsigned trigger_;
  const Clock& clock_;
  Bell bell_;
};

}  // namespace

Result<std::unique_ptr<EchoLines>, Problem> request_echo_lines(const EchoSettings& settings, const Clock& clock) {
  const Chip chip{gpiod_chip_open(settings.chip.c_str())};
  if (!chip) return err(explain_echo_lines(settings, errno));
  const LineSettings trigger{gpiod_line_settings_new()}, echo{gpiod_line_settings_new()};
  const LineConfig lines{gpiod_line_config_new()};
  const RequestConfig config{gpiod_request_config_new()};
  EventBuffer events{gpiod_edge_event_buffer_new(1)};
  if (!trigger || !echo || !lines || !config || !events) return err(explain_echo_lines(settings, ENOMEM));
  gpiod_request_config_set_consumer(config.get(), "nacelle-range");
  if (gpiod_line_settings_set_direction(trigger.get(), GPIOD_LINE_DIRECTION_OUTPUT) != 0 ||
      gpiod_line_settings_set_output_value(trigger.get(), GPIOD_LINE_VALUE_INACTIVE) != 0 ||
      gpiod_line_settings_set_direction(echo.get(), GPIOD_LINE_DIRECTION_INPUT) != 0 ||
      gpiod_line_settings_set_edge_detection(echo.get(), GPIOD_LINE_EDGE_BOTH) != 0 ||
      gpiod_line_config_add_line_settings(lines.get(), &settings.trigger_line, 1, trigger.get()) != 0 ||
      gpiod_line_config_add_line_settings(lines.get(), &settings.echo_line, 1, echo.get()) != 0) {
    return err(explain_echo_lines(settings, errno));
  }
  Request request{gpiod_chip_request_lines(chip.get(), config.get(), lines.get())};
  if (!request) return err(explain_echo_lines(settings, errno));
  return std::unique_ptr<EchoLines>{
      std::make_unique<Lines>(std::move(request), std::move(events), settings.trigger_line, clock)};
}

}  // namespace nacelle::range
