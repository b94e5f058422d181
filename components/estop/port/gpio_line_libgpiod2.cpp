// SPDX-License-Identifier: Apache-2.0
// A line through libgpiod 2 (Debian 13).
#include <gpiod.h>

#include <cerrno>
#include <utility>

#include "estop/port/gpio_line.hpp"

namespace nacelle::estop {
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

class Line final : public RequestedLine {
 public:
  Line(Request request, EventBuffer events, unsigned offset)
      : request_(std::move(request)), events_(std::move(events)), offset_(offset) {}
  int descriptor() const override { return gpiod_line_request_get_fd(request_.get()); }
  int value() override {
    switch (gpiod_line_request_get_value(request_.get(), offset_)) {
      case GPIOD_LINE_VALUE_ACTIVE: return 1;
      case GPIOD_LINE_VALUE_INACTIVE: return 0;
      default: return -1;
    }
  }
  bool take_event() override { return gpiod_line_request_read_edge_events(request_.get(), events_.get(), 1) >= 0; }

 private:
  Request request_;
  EventBuffer events_;
  unsigned offset_;
};

gpiod_line_bias bias_of(Bias bias) {
  switch (bias) {
    case Bias::PullUp: return GPIOD_LINE_BIAS_PULL_UP;
    case Bias::PullDown: return GPIOD_LINE_BIAS_PULL_DOWN;
    case Bias::None: return GPIOD_LINE_BIAS_DISABLED;
  }
  return GPIOD_LINE_BIAS_AS_IS;
}

}  // namespace

std::string_view gpio_library() { return "libgpiod 2"; }

Result<std::unique_ptr<RequestedLine>, Problem> request_line(const GpioSettings& settings) {
  const Chip chip{gpiod_chip_open(settings.chip.c_str())};
  if (!chip) return err(explain_gpio(settings, errno));
  const LineSettings line{gpiod_line_settings_new()};
  const LineConfig lines{gpiod_line_config_new()};
  const RequestConfig config{gpiod_request_config_new()};
  EventBuffer events{gpiod_edge_event_buffer_new(1)};
  if (!line || !lines || !config || !events) return err(explain_gpio(settings, ENOMEM));
  gpiod_request_config_set_consumer(config.get(), "nacelle-estop");
  if (gpiod_line_settings_set_direction(line.get(), GPIOD_LINE_DIRECTION_INPUT) != 0 ||
      gpiod_line_settings_set_edge_detection(line.get(), GPIOD_LINE_EDGE_BOTH) != 0 ||
      gpiod_line_settings_set_bias(line.get(), bias_of(settings.bias)) != 0 ||
      gpiod_line_config_add_line_settings(lines.get(), &settings.line, 1, line.get()) != 0) {
    return err(explain_gpio(settings, errno));
  }
  Request request{gpiod_chip_request_lines(chip.get(), config.get(), lines.get())};
  if (!request) return err(explain_gpio(settings, errno));
  return std::unique_ptr<RequestedLine>{std::make_unique<Line>(std::move(request), std::move(events), settings.line)};
}

}  // namespace nacelle::estop
