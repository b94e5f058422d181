// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ekf/component/ekf_component.hpp"
#include "ekf/model/process_model.hpp"

namespace nacelle::ekf {
namespace {

RigidTransform pose_of(const StateVector& x) {
  return {spatial::quaternion_from_rpy({x[kRoll], x[kPitch], x[kYaw]}), {x[kX], x[kY], x[kZ]}};
}

}  // namespace

// Where the odometry saw the base at the estimate's time. If it has not come that far, the estimate is taken back to the latest that there
// is: robot_localization does not, and its map -> odom jitters by the way driven between the two stamps.
std::optional<RigidTransform> EkfComponent::map_to_odom(const Filter::Output& output) {
  constexpr Duration kMostBack = 500ms;
  StateVector x = output.belief->mean;
  auto X_BO = buffer_->lookup(options_->base_link_frame, options_->odom_frame, output.stamp);
  if (!X_BO) {
    X_BO = buffer_->lookup_latest(options_->base_link_frame, options_->odom_frame);
    if (!X_BO) {
      if (!std::exchange(told_no_odom_, true))
        get_logger().warn("{} -> {} is not broadcast: {}", options_->map_frame, options_->odom_frame,
                          X_BO.error().text());
      return std::nullopt;
    }
    const Duration back = output.stamp - X_BO->stamp;
    if (back > 0ns && back <= kMostBack) x = propagate(x, -to_seconds(back));
  }
  if (std::exchange(told_no_odom_, false))
    get_logger().info("{} -> {} is broadcast again", options_->map_frame, options_->odom_frame);
  return pose_of(x) * X_BO->X_TS;
}

std::optional<Problem> EkfComponent::open_debug_output() {
  debug_.reset();
  if (!options_->debug) return std::nullopt;
  auto file = DebugFile::open(options_->debug_out_file);
  if (!file) return file.error();
  std::vector<std::string> parts;
  for (const auto& input : inputs_) {
    for (const auto& part : input->parts()) parts.push_back(part.name);
  }
  debug_ = std::make_unique<DebugOutput>(std::move(file).value(), std::move(parts));
  filter_->observe(debug_.get());
  get_logger().warn("debug: every measurement is written to {}", debug_->path());
  return std::nullopt;
}

bool EkfComponent::toggle(bool on) {
  if (on == toggled_on_) {
    get_logger().warn("toggle: measurements are {} already", on ? "processed" : "ignored");
    return false;
  }
  toggled_on_ = on;
  if (on) {
    for (const auto& input : inputs_) {
      input->begin();
      input->skip_motion();
    }
    if (watch_) watch_.emplace(inputs_, *filter_, skews_);
  }
  get_logger().info("toggle: measurements are {}", on ? "processed again" : "ignored, and the estimate stands");
  return true;
}

}  // namespace nacelle::ekf
