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

}  // namespace nacelle::diff_drive
