// SPDX-License-Identifier: Apache-2.0
#include "estop/port/gpio_line.hpp"

#include <utility>

#include "nacelle/io/descriptor.hpp"
#include "nacelle/io/gpio_lines.hpp"

namespace nacelle::estop {
namespace {

class GpioSwitch final : public SwitchPort {
 public:
  GpioSwitch(std::unique_ptr<RequestedLine> line, bool stops_when_high, const Clock& clock)
      : line_(std::move(line)), stops_when_high_(stops_when_high), clock_(clock) {}

  Result<bool, SwitchFault> is_pressed() override {
    const int value = line_->value();
    if (value < 0) return err(SwitchFault::Lost);
    return (value != 0) == stops_when_high_;
  }
  Result<bool, SwitchFault> wait_until(MonotonicTime deadline) override {
    switch (io::wait_readable(line_->descriptor(), bell_, clock_, deadline)) {
      case io::Wake::TimedOut:
      case io::Wake::Woken: return false;
      case io::Wake::HungUp: return err(SwitchFault::Lost);
      case io::Wake::Ready: break;
    }
    if (!line_->take_event()) return err(SwitchFault::Lost);
    return true;
  }
  void interrupt() noexcept override { bell_.ring(); }

 private:
  std::unique_ptr<RequestedLine> line_;
  const bool stops_when_high_;
  const Clock& clock_;
  Bell bell_;
};

}  // namespace

Problem explain_gpio(const GpioSettings& settings, int os_code) {
  return io::explain_gpio({settings.chip, {settings.line}}, os_code);
}

std::unique_ptr<SwitchPort> switch_on(std::unique_ptr<RequestedLine> line, bool stops_when_high, const Clock& clock) {
  return std::make_unique<GpioSwitch>(std::move(line), stops_when_high, clock);
}

Result<std::unique_ptr<SwitchPort>, Problem> open_gpio_switch(const GpioSettings& settings, const Clock& clock) {
  auto line = request_line(settings);
  if (!line) return err(line.error());
  return switch_on(std::move(line).value(), settings.stops_when_high, clock);
}

}  // namespace nacelle::estop
