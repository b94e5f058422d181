// SPDX-License-Identifier: Apache-2.0
// A line through libgpiod 1.6 (Debian 12).
#include <gpiod.h>

#include <cerrno>
#include <utility>

#include "estop/port/gpio_line.hpp"

namespace nacelle::estop {
namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }  // its lines too
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

class Line final : public RequestedLine {
 public:
  Line(Chip chip, gpiod_line* line) : chip_(std::move(chip)), line_(line) {}
  int descriptor() const override { return gpiod_line_event_get_fd(line_); }
  int value() override { return gpiod_line_get_value(line_); }
  bool take_event() override {
    gpiod_line_event event{};
    return gpiod_line_event_read(line_, &event) == 0;
  }

 private:
  Chip chip_;
  gpiod_line* line_;
};

int flags_of(Bias bias) {
  switch (bias) {
    case Bias::PullUp: return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
    case Bias::PullDown: return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
    case Bias::None: return GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  }
  return 0;
}

}  // namespace

std::string_view gpio_library() { return "libgpiod 1"; }

Result<std::unique_ptr<RequestedLine>, Problem> request_line(const GpioSettings& settings) {
  Chip chip{gpiod_chip_open(settings.chip.c_str())};
  if (!chip) return err(explain_gpio(settings, errno));
  gpiod_line* const line = gpiod_chip_get_line(chip.get(), settings.line);
  if (line == nullptr) return err(explain_gpio(settings, errno));
  if (gpiod_line_request_both_edges_events_flags(line, "nacelle-estop", flags_of(settings.bias)) != 0)
    return err(explain_gpio(settings, errno));
  return std::unique_ptr<RequestedLine>{std::make_unique<Line>(std::move(chip), line)};
}

}  // namespace nacelle::estop
