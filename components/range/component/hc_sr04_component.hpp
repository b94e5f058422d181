// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/node/lifecycle_node.hpp"
#include "range/component/range_loop.hpp"

namespace nacelle::range {

/// An HC-SR04 on two GPIO lines, published as sensor_msgs/Range on `range` (node name "range"): +Inf if nothing is in range, -Inf if something
/// is nearer than min_range (REP 117). Stamp: when the sound left.
///
/// configure opens the lines, if their chip is there; while the node is active, the thread "range" measures.
/// Errors: an open fault DEVICE_LOST while the chip is absent or the sensor does not answer (0.5 s or three periods); with device_lost: fault
/// the fault RANGE_SILENT after silence_limit.
class HcSr04Component final : public LifecycleNode {
 public:
  explicit HcSr04Component(const NodeOptions& options) : HcSr04Component(options, request_echo_lines) {}
  /// With other lines.
  HcSr04Component(const NodeOptions& options, RangeLoop::OpenLines open_lines);
  ~HcSr04Component() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State& state) override { return on_cleanup(state); }
  CallbackReturn on_error(const State& state) override { return on_cleanup(state); }

  [[nodiscard]] Result<RangeOptions, Problem> read_options() const;

  const RangeLoop::OpenLines open_lines_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Range>> publisher_;
  RangeOptions options_;
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<EchoLines> lines_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<RangeLoop> loop_;
};

}  // namespace nacelle::range
