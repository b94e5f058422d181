// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/pwm_base.hpp"

#include <cmath>

#include "diff_drive/port/counter_encoders.hpp"
#include "diff_drive/port/edge_encoders.hpp"
#include "diff_drive/port/pwm_base_port.hpp"

namespace nacelle::diff_drive {
namespace {

Problem at_parameter(Problem problem, const char* parameter) {
  problem.where.parameter = parameter;
  return problem;
}

io::GpioRequest request_of(const PwmOptions& options, const std::vector<std::int64_t>& left,
                           const std::vector<std::int64_t>& right) {
  io::GpioRequest request;
  request.chip = options.gpio_chip;
  request.consumer = "nacelle-diff-drive";
  for (const auto* const lines : {&left, &right}) {
    for (const std::int64_t line : *lines) request.lines.push_back(static_cast<unsigned>(line));
  }
  return request;
}

Result<std::unique_ptr<HBridges>, Problem> open_motors(const PwmOptions& options, const BaseWiring& wiring) {
  auto lines = io::request_gpio_outputs(request_of(options, options.left_lines, options.right_lines));
  if (!lines) return err(at_parameter(lines.error(), "pwm.left_lines"));
  PwmSettings settings;
  settings.chip = options.chip;
  settings.period_ns = static_cast<std::uint64_t>(std::llround(1e9 / options.frequency_hz));
  settings.is_inverted = options.is_inverted;
  settings.channel = static_cast<unsigned>(wiring.left.channel);
  auto left = PwmChannel::open(settings);
  if (!left) return err(at_parameter(left.error(), "pwm.chip"));
  settings.channel = static_cast<unsigned>(wiring.right.channel);
  auto right = PwmChannel::open(settings);
  if (!right) return err(at_parameter(right.error(), "pwm.chip"));
  return std::make_unique<HBridges>(std::move(left).value(), std::move(right).value(), std::move(lines).value());
}

Result<std::unique_ptr<WheelEncoders>, Problem> open_encoders(const PwmOptions& options) {
  if (options.encoder == "counter") {
    auto counters = CounterEncoders::open(options.left_counter, options.right_counter);
    if (!counters) return err(at_parameter(counters.error(), "pwm.left_counter"));
    return counters;
  }
  auto request = request_of(options, options.left_encoder_lines, options.right_encoder_lines);
  request.pulls_up = true;  // open collectors of Hall sensors need it, and it does no harm to others
  auto lines = io::request_gpio_inputs(request);
  if (!lines) return err(at_parameter(lines.error(), "pwm.left_encoder_lines"));
  return std::unique_ptr<WheelEncoders>{
      std::make_unique<EdgeEncoders>(std::move(lines).value(), options.left_encoder_lines.size() == 2)};
}

}  // namespace

Result<std::unique_ptr<BasePort>, Problem> open_pwm_base(const DiffDriveOptions& options, const BaseWiring& wiring,
                                                         const Clock& clock) {
  const PwmOptions& pwm = options.pwm;
  auto motors = open_motors(pwm, wiring);
  if (!motors) return err(motors.error());
  auto encoders = open_encoders(pwm);
  if (!encoders) return err(encoders.error());
  PwmBasePort::Settings settings;
  settings.left = {wiring.left.is_reversed, pwm.left_encoder_reversed};
  settings.right = {wiring.right.is_reversed, pwm.right_encoder_reversed};
  settings.counts_per_turn = wiring.counts_per_turn;
  settings.max_wheel_rate_rps = options.max_wheel_rate_rps;
  settings.pid = {.feed_forward = pwm.feed_forward,
                  .p = pwm.p,
                  .i = pwm.i,
                  .d = pwm.d,
                  .filter_s = pwm.derivative_filter_s,
                  // So that the share is pwm.max_duty there: beyond_dead_band().
                  .output_limit = (pwm.max_duty - pwm.min_duty) / (1.0 - pwm.min_duty)};
  settings.min_duty = pwm.min_duty;
  settings.max_duty = pwm.max_duty;
  settings.stall_limit_s = pwm.stall_timeout_s;
  return std::unique_ptr<BasePort>{
      std::make_unique<PwmBasePort>(std::move(motors).value(), std::move(encoders).value(), clock, settings)};
}

}  // namespace nacelle::diff_drive
