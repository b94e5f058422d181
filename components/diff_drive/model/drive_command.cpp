// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/drive_command.hpp"

#include <cmath>

namespace nacelle::diff_drive {

Result<BodyTwist, CommandFault> accepted(const RawTwist& twist) {
  // A message with one broken number is a broken message, even if the base does not use that number.
  for (const double part :
       {twist.linear_x, twist.linear_y, twist.linear_z, twist.angular_x, twist.angular_y, twist.angular_z}) {
    if (!std::isfinite(part)) return err(CommandFault::NotFinite);
  }
  if (std::abs(twist.linear_x) > kMaxSaneLinear_mps || std::abs(twist.angular_z) > kMaxSaneAngular_rps) {
    return err(CommandFault::Absurd);
  }
  return BodyTwist{twist.linear_x, twist.angular_z};
}

void CommandWatch::arm(MonotonicTime now) {
  armed_at_ = now;
  command_ = {};
  state_ = State::Waiting;
}

bool CommandWatch::take(const DriveCommand& command) {
  if (command.received_at < armed_at_) {
    ++stats_.early;
    return false;
  }
  command_ = command;
  state_ = State::Driving;
  ++stats_.taken;
  return true;
}

BodyTwist CommandWatch::wanted(MonotonicTime now) {
  if (state_ == State::Driving && timeout_ > Duration::zero() && now - command_.received_at > timeout_) {
    state_ = State::TimedOut;
    ++stats_.timeouts;
  }
  return state_ == State::Driving ? command_.wanted : BodyTwist{};
}

}  // namespace nacelle::diff_drive
